#include "pipeline/inventory_join.hpp"

#include <algorithm>
#include <cstdint>
#include <map>
#include <set>
#include <tuple>

#include "base/error.hpp"
#include "base/number_text.hpp"
#include "base/time.hpp"
#include "io/csv.hpp"
#include "io/field_notes.hpp"

namespace cairn::pipeline {
namespace {

using base::Error;
using base::ErrorCode;

// A second rock about as near as the nearest: the note does not say which is meant.
constexpr double kAmbiguousRatio = 1.5;
constexpr double kClearGap_m = 1.0;

std::vector<std::string> split_ids(std::string_view text) {
  std::vector<std::string> ids;
  while (!text.empty()) {
    const auto end = text.find(';');
    const auto id = base::trim(text.substr(0, end));
    if (!id.empty()) ids.emplace_back(id);
    text = end == std::string_view::npos ? std::string_view() : text.substr(end + 1);
  }
  return ids;
}

struct Joined {
  const io::FieldNote* note = nullptr;
  std::string match;
  std::optional<double> distance_m;
};

void put_values(report::InventoryRock& rock, const std::vector<Joined>& notes, const std::filesystem::path& path) {
  // Newest first, as the first value of a field counts; without times the later row is the newer.
  std::vector<Joined> order = notes;
  std::reverse(order.begin(), order.end());
  std::stable_sort(order.begin(), order.end(), [](const Joined& a, const Joined& b) {
    return a.note->observed_ns.value_or(INT64_MIN) > b.note->observed_ns.value_or(INT64_MIN);
  });
  for (const auto& joined : order) {
    if (joined.note->observed_ns)
      rock.field.emplace_back("observed_utc", base::iso8601(*joined.note->observed_ns).substr(0, 19) + "Z");
    for (const auto& [column, value] : joined.note->values) {
      const auto field = report::inventory_field(column);
      if (field)
        if (const auto problem = report::field_problem(*field, value); !problem.empty())
          throw Error(ErrorCode::invalid_input, "a value of the field notes does not fit its column")
              .file(path.string())
              .record("line " + std::to_string(joined.note->line) + ", column " + column)
              .found("'" + value + "'")
              .allowed(problem);
      rock.field.emplace_back(field ? *field : "note_" + column, value);
    }
  }
  rock.note_match = order.front().match;
  rock.note_distance_m = order.front().distance_m;
  rock.notes = order.size();
}

}  // namespace

RockPlaces::RockPlaces(const report::Inventory& inventory)
    : known_(inventory.rocks.size(), false),
      degrees_(inventory.rocks.size(), geometry::Vec2::Zero()),
      earth_(inventory.rocks.size(), geometry::Vec3::Zero()) {
  std::vector<std::optional<geodesy::LocalFrame>> frames;
  for (const auto& survey : inventory.surveys) {
    frames.push_back(survey.origin ? std::optional(geodesy::LocalFrame(survey.origin->position)) : std::nullopt);
    if (!frame_ && survey.origin)
      frame_.emplace(
          geometry::Geodetic{survey.origin->position.latitude_deg, survey.origin->position.longitude_deg, 0});
  }
  for (std::size_t i = 0; i < inventory.rocks.size(); ++i) {
    const auto& rock = inventory.rocks[i];
    const auto place = report::place_of(rock.rock, rock.target);
    const auto& frame = frames[rock.survey];
    if (!place || !frame) continue;
    auto g = frame->to_geodetic(*place);
    g.height_m = 0.0;
    known_[i] = true;
    degrees_[i] = {g.latitude_deg, g.longitude_deg};
    earth_[i] = frame_->to_local(g);
  }
}

std::vector<RockPlaces::Near> RockPlaces::within(double latitude_deg, double longitude_deg, double limit) const {
  std::vector<Near> near;
  if (!frame_) return near;
  const auto p = frame_->to_local({latitude_deg, longitude_deg, 0.0});
  for (std::size_t i = 0; i < known_.size(); ++i)
    if (known_[i])
      if (const double d = (earth_[i] - p).norm(); d <= limit) near.push_back({i, d});
  std::stable_sort(near.begin(), near.end(), [](const Near& a, const Near& b) { return a.distance_m < b.distance_m; });
  return near;
}

std::vector<base::Reject> join_notes(report::Inventory& inventory, const InventoryOptions& options) {
  const std::filesystem::path path = options.notes;
  const io::FieldNotes file = io::read_field_notes(path);
  std::map<std::string, std::size_t, std::less<>> by_id;
  const auto enter = [&](const std::string& id, std::size_t i) {
    if (!id.empty()) by_id.emplace(id, i);
  };
  for (std::size_t i = 0; i < inventory.rocks.size(); ++i) enter(inventory.rocks[i].id, i);
  for (std::size_t i = 0; i < inventory.rocks.size(); ++i) {
    for (const auto& alias : inventory.rocks[i].aliases) enter(alias, i);
    // The survey's own numbers are unique within one survey only.
    if (inventory.surveys.size() == 1) {
      enter(std::to_string(inventory.rocks[i].rock.target.value), i);
      for (const auto alias : inventory.rocks[i].rock.aliases) enter(std::to_string(alias.value), i);
    }
  }
  const RockPlaces places(inventory);
  std::vector<base::Reject> rejects;
  std::map<std::size_t, std::vector<Joined>> joined;
  for (const auto& note : file.notes) {
    const std::string record = "note, line " + std::to_string(note.line);
    if (!note.id.empty()) {
      const auto it = by_id.find(note.id);
      if (it == by_id.end())
        throw Error(ErrorCode::invalid_input, "the note names a rock that is not in the inventory")
            .file(path.string())
            .record("line " + std::to_string(note.line))
            .found("'" + note.id + "'")
            .allowed(inventory.rocks.empty() ? "none: there are no rocks"
                                             : "ids like '" + inventory.rocks.front().id + "'")
            .hint("Correct the id, or leave it empty and give latitude_deg and longitude_deg");
      joined[it->second].push_back({&note, "id", std::nullopt});
      continue;
    }
    const auto near = places.within(*note.latitude_deg, *note.longitude_deg, options.notes_within_m);
    if (near.empty()) {
      rejects.push_back(
          {record, "note_no_rock_near", "no rock lies within " + base::to_text(options.notes_within_m) + " m"});
    } else if (near.size() > 1 && near[1].distance_m < kAmbiguousRatio * near[0].distance_m &&
               near[1].distance_m - near[0].distance_m < kClearGap_m) {
      rejects.push_back({record, "note_ambiguous",
                         inventory.rocks[near[0].rock].id + " at " + base::to_fixed(near[0].distance_m, 2) + " m and " +
                             inventory.rocks[near[1].rock].id + " at " + base::to_fixed(near[1].distance_m, 2) +
                             " m: give the id"});
    } else {
      joined[near.front().rock].push_back({&note, "position", near.front().distance_m});
    }
  }
  for (const auto& [rock, notes] : joined) put_values(inventory.rocks[rock], notes, path);
  std::set<std::string> known;
  for (const auto& column : file.columns)
    if (!report::inventory_field(column) && known.insert(column).second) inventory.note_columns.push_back(column);
  return rejects;
}

std::size_t keep_previous_ids(report::Inventory& inventory, const InventoryOptions& options) {
  io::CsvReader csv{std::filesystem::path(options.previous)};
  const auto id = csv.column("id"), latitude = csv.column("latitude_deg"), longitude = csv.column("longitude_deg"),
             hidden = csv.column("coordinates_protected"), aliases = csv.column("aliases");
  struct Before {
    std::string id;
    double latitude_deg = 0.0, longitude_deg = 0.0;
    std::vector<std::string> aliases;
  };
  std::vector<Before> before;
  std::set<std::string> taken;
  while (csv.next()) {
    if (csv.text(hidden) == "true")
      throw csv.error(hidden, "the earlier inventory is protected: its positions are rounded")
          .hint("Give the inventory that was made without --protect");
    Before b{std::string(csv.required(id)), 0.0, 0.0, split_ids(csv.text(aliases))};
    if (!taken.insert(b.id).second) throw csv.error(id, "the id stands twice");
    const auto lat = csv.optional_real(latitude), lon = csv.optional_real(longitude);
    if (!lat || !lon) continue;
    b.latitude_deg = *lat;
    b.longitude_deg = *lon;
    before.push_back(std::move(b));
  }
  // Nearest pairs first, each rock and each earlier rock once.
  const RockPlaces places(inventory);
  struct Pair {
    double distance_m = 0.0;
    std::size_t before = 0, rock = 0;
  };
  std::vector<Pair> pairs;
  for (std::size_t b = 0; b < before.size(); ++b)
    for (const auto& near : places.within(before[b].latitude_deg, before[b].longitude_deg, options.same_within_m))
      pairs.push_back({near.distance_m, b, near.rock});
  std::sort(pairs.begin(), pairs.end(), [](const Pair& a, const Pair& b) {
    return std::tie(a.distance_m, a.before, a.rock) < std::tie(b.distance_m, b.before, b.rock);
  });
  std::vector<bool> used(before.size(), false), named(inventory.rocks.size(), false);
  std::size_t kept = 0;
  for (const auto& pair : pairs) {
    if (used[pair.before] || named[pair.rock]) continue;
    used[pair.before] = named[pair.rock] = true;
    ++kept;
    auto& rock = inventory.rocks[pair.rock];
    const auto add = [&rock](const std::string& alias, const std::string& own) {
      if (alias != own && std::find(rock.aliases.begin(), rock.aliases.end(), alias) == rock.aliases.end())
        rock.aliases.push_back(alias);
    };
    const std::string fresh = rock.id;
    rock.id = before[pair.before].id;
    // An id that another rock kept from before cannot be this one's alias.
    if (!taken.contains(fresh)) add(fresh, rock.id);
    for (const auto& alias : before[pair.before].aliases) add(alias, rock.id);
  }
  // A rock that is new must not bear an id that meant another one.
  for (std::size_t i = 0; i < inventory.rocks.size(); ++i) {
    if (named[i]) continue;
    std::string fresh = inventory.rocks[i].id;
    for (int n = 2; taken.contains(fresh); ++n) fresh = inventory.rocks[i].id + "-" + std::to_string(n);
    inventory.rocks[i].id = fresh;
    taken.insert(fresh);
  }
  return kept;
}

std::size_t find_revisits(report::Inventory& inventory, double same_within_m) {
  if (inventory.surveys.size() < 2) return 0;
  const RockPlaces places(inventory);
  std::size_t found = 0;
  std::set<std::pair<std::size_t, std::size_t>> taken;  // earlier rock, later survey
  for (std::size_t i = 0; i < inventory.rocks.size(); ++i) {
    auto& rock = inventory.rocks[i];
    if (!places.has(i) || rock.rock.rejected) continue;
    for (const auto& near : places.within(places.latitude(i), places.longitude(i), same_within_m)) {
      const auto& other = inventory.rocks[near.rock];
      if (other.survey >= rock.survey || other.rock.rejected || !other.revisit_of.empty()) continue;
      if (!taken.emplace(near.rock, rock.survey).second) continue;
      rock.revisit_of = other.id;
      ++found;
      break;
    }
  }
  return found;
}

}  // namespace cairn::pipeline
