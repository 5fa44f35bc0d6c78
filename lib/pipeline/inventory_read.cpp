#include "pipeline/inventory_read.hpp"

#include <algorithm>
#include <map>
#include <set>

#include "base/digest.hpp"
#include "base/error.hpp"
#include "geodesy/crs.hpp"
#include "io/json.hpp"
#include "io/rocks_json.hpp"
#include "io/survey_folder.hpp"
#include "io/survey_json.hpp"
#include "io/targets_json.hpp"
#include "pipeline/review_record.hpp"

namespace cairn::pipeline {
namespace fs = std::filesystem;
namespace {

using base::Error;
using base::ErrorCode;

constexpr std::size_t kPhotosOfRock = 5;

// rocks.json; results of a single mesh stand in no frame.
std::vector<survey::Rock> rocks_of(const fs::path& file, std::optional<survey::Origin>& origin) {
  const io::Json json = io::read_json(file);
  const io::Json* frame = json.find("frame");
  if (frame != nullptr && !frame->is_null()) {
    auto rocks = io::read_rocks(file);
    origin = rocks.frame;
    return std::move(rocks.rocks);
  }
  std::vector<survey::Rock> rocks;
  std::set<std::int64_t> ids;
  try {
    for (const auto& record : json.at("rocks").as_array()) {
      rocks.push_back(io::rock_from_json(record));
      if (!ids.insert(rocks.back().target.value).second)
        throw Error(ErrorCode::invalid_input, "two rocks have one id").found(std::to_string(rocks.back().target.value));
    }
  } catch (Error& error) {
    error.default_file(file.string());
    throw;
  }
  return rocks;
}

// run.json of the result; null where there is none.
io::Json run_record(const fs::path& result) {
  const fs::path file = result / "run.json";
  return fs::exists(file) ? io::read_json(file) : io::Json();
}

const io::Json* argument(const io::Json& run, std::string_view name) {
  const io::Json* arguments = run.is_object() ? run.find("arguments") : nullptr;
  const io::Json* value = arguments == nullptr || !arguments->is_object() ? nullptr : arguments->find(name);
  return value != nullptr && value->is_string() && !value->as_string().empty() ? value : nullptr;
}

// The mesh of a rock: in the result, else where `fragility` read it from.
fs::path mesh_of(const fs::path& result, const io::Json& run, std::int64_t id) {
  const std::string name = std::to_string(id) + ".ply";
  std::vector<fs::path> places{result / "rocks" / name, result / name};
  if (const io::Json* input = argument(run, "rocks")) {
    const fs::path path = input->as_string();
    places.push_back(path / name);
    if (path.extension() == ".ply") places.push_back(path);
  }
  for (const auto& place : places)
    if (fs::is_regular_file(place)) return place;
  return {};
}

class Photographs {
 public:
  Photographs(fs::path folder, const survey::Survey& survey) : folder_(std::move(folder)), survey_(survey) {}

  void add(report::InventoryRock& rock) {
    if (!rock.target) return;
    std::map<survey::FrameId, double> best;
    for (const auto id : rock.target->detections)
      if (const auto* detection = survey_.detection(id)) {
        auto& score = best[detection->frame];
        score = std::max(score, detection->score);
      }
    std::vector<std::pair<survey::FrameId, double>> order(best.begin(), best.end());
    std::stable_sort(order.begin(), order.end(), [](const auto& a, const auto& b) { return a.second > b.second; });
    rock.photo_count = order.size();
    for (const auto& [id, score] : order) {
      const auto* frame = survey_.frame(id);
      if (frame == nullptr || frame->image.empty()) continue;
      if (rock.photos.size() == kPhotosOfRock) break;
      report::InventoryPhoto photo;
      photo.file = fs::path(frame->image).filename().string();
      photo.sha256 = digest(io::resolve_reference(frame->image, folder_));
      photo.time_ns = frame->time_ns;
      photo.time_base = survey_.manifest.time_base;
      photo.camera = frame->camera.value;
      photo.score = score;
      photo.T_world_camera = frame->T_world_camera;
      rock.photos.push_back(std::move(photo));
    }
  }

 private:
  const std::string& digest(const fs::path& file) {
    auto [it, fresh] = digests_.try_emplace(file);
    if (fresh && fs::is_regular_file(file)) it->second = base::sha256_of_file(file);
    return it->second;
  }

  fs::path folder_;
  const survey::Survey& survey_;
  std::map<fs::path, std::string> digests_;
};

void take_review(report::InventoryRock& rock, const ReviewRecord& review) {
  const auto it = review.rocks.find(rock.rock.target.value);
  if (it == review.rocks.end()) return;
  rock.judgement = it->second.judgement;
  rock.reviewer = it->second.reviewer;
  rock.reviewed_utc = it->second.time;
  rock.review_reason = it->second.reason;
  for (const auto& note : it->second.notes) rock.review_notes += (rock.review_notes.empty() ? "" : "; ") + note;
  // The analysis was made with the density already.
  for (const auto& [name, value] : it->second.fields)
    if (name != "density_kg_m3") rock.field.emplace_back(name, value);
}

}  // namespace

void add_result(report::Inventory& inventory, std::vector<fs::path>& meshes, const InventorySource& source,
                base::RunContext& ctx) {
  report::InventorySurvey survey;
  survey.name = source.name;
  survey.slug = report::slug_of(report::protected_text(source.name, inventory.protection));
  survey.version = source.version;
  survey.seed = source.seed;
  survey.result = fs::path(source.result).lexically_normal().filename().string();
  if (survey.result.empty())
    survey.result = fs::absolute(source.result).lexically_normal().parent_path().filename().string();
  const io::Json run = run_record(source.result);
  if (run.is_object()) {
    if (const auto* version = run.find("cairn_version"); version != nullptr && version->is_string())
      survey.version = version->as_string();
    if (const auto* seed = run.find("seed"); seed != nullptr && seed->is_integer()) survey.seed = seed->as_integer();
  }
  auto rocks = rocks_of(source.result / "rocks.json", survey.origin);
  std::map<survey::TargetId, survey::Target> targets;
  if (const fs::path file = source.result / "targets.json"; survey.origin && fs::exists(file)) {
    auto read = io::read_targets(file);
    io::require_same_frame(read.frame, *survey.origin, file.string());
    for (auto& target : read.targets) targets.emplace(target.id, std::move(target));
  }
  ReviewRecord review;
  if (const fs::path file = source.result / "review.json"; fs::exists(file)) review = read_review(file);
  survey::Survey recorded;
  if (!source.survey.empty()) recorded = io::read_survey(source.survey);
  Photographs photographs(source.survey, recorded);

  const std::size_t index = inventory.surveys.size();
  const std::optional<geodesy::LocalFrame> frame =
      survey.origin ? std::optional(geodesy::LocalFrame(survey.origin->position)) : std::nullopt;
  bool grid = frame.has_value();
  for (auto& rock : rocks) {
    ctx.check_stop();
    report::InventoryRock entry;
    entry.survey = index;
    entry.id = report::inventory_id(survey.slug, rock.target);
    for (const auto alias : rock.aliases) entry.aliases.push_back(report::inventory_id(survey.slug, alias));
    for (const auto old : rock.supersedes) entry.supersedes.push_back(report::inventory_id(survey.slug, old));
    const auto target = targets.find(rock.target);
    if (target != targets.end()) entry.target = target->second;
    entry.rock = std::move(rock);
    if (const auto place = report::place_of(entry.rock, entry.target); place && grid) {
      try {
        entry.undulation_m = geodesy::geoid_undulation("egm96", frame->to_geodetic(*place));
      } catch (const Error&) {
        grid = false;
        ctx.warn("EGM96's grid is not installed: orthometric heights are left empty");
      }
    }
    take_review(entry, review);
    photographs.add(entry);
    const fs::path mesh = entry.rock.rejected ? fs::path() : mesh_of(source.result, run, entry.rock.target.value);
    if (!mesh.empty()) {
      const auto within = mesh.lexically_relative(source.result);
      entry.mesh_file = within.empty() || *within.begin() == ".." ? mesh.filename().string() : within.string();
      entry.mesh_sha256 = base::sha256_of_file(mesh);
    }
    meshes.push_back(mesh);
    inventory.rocks.push_back(std::move(entry));
  }
  inventory.surveys.push_back(std::move(survey));
}

InventorySource inventory_source(const fs::path& result) {
  if (!fs::is_regular_file(result / "rocks.json"))
    throw Error(ErrorCode::invalid_input, "the folder holds no rocks")
        .file(result.string())
        .found(fs::exists(result) ? "no rocks.json" : "no such folder")
        .allowed("a folder of cairn run, cairn review or cairn fragility");
  InventorySource source{result, "", "", "", std::nullopt};
  const io::Json run = run_record(result);
  if (const io::Json* survey = argument(run, "survey"))
    if (const fs::path folder = survey->as_string(); fs::is_regular_file(folder / "survey.json")) {
      const auto manifest =
          io::manifest_from_json(io::read_json(folder / "survey.json"), (folder / "survey.json").string());
      const auto rocks = io::read_json(result / "rocks.json");
      const io::Json* frame = rocks.find("frame");
      // A survey that was made anew since is not the one these rocks stand in.
      if (frame != nullptr && !frame->is_null() && io::origin_from_json(*frame).position == manifest.origin.position) {
        source.survey = folder;
        source.name = manifest.name;
      }
    }
  if (source.name.empty()) {
    if (const io::Json* name = run.is_object() ? run.find("survey_name") : nullptr;
        name != nullptr && name->is_string())
      source.name = name->as_string();
    else source.name = fs::absolute(result).lexically_normal().filename().string();
    if (source.name.empty()) source.name = fs::absolute(result).lexically_normal().parent_path().filename().string();
  }
  return source;
}

}  // namespace cairn::pipeline
