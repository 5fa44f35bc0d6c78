#include "ground/obstacle_map.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <set>
#include <utility>

#include "geometry/assignment.hpp"
#include "ground/image_footprint.hpp"
#include "ground/obstacle_track.hpp"

namespace cairn::ground {
namespace {

using geometry::Mat2;
using geometry::Vec2;
using survey::ObstacleKind;

constexpr double kNs = 1e-9;

double log_odds(double probability) {
  return std::log(probability / (1.0 - probability));
}

struct Sighting {
  Look look;
  ObstacleKind kind = ObstacleKind::obstacle;
};

// The look, or why it cannot be used.
std::optional<Look> look_of(const geometry::Vec3& position, const Mat2& covariance, double unknown_sigma,
                            const std::string& record, std::vector<base::Reject>& rejects) {
  if (!position.allFinite()) {
    rejects.push_back({record, "bad_position", "its position is not finite"});
    return std::nullopt;
  }
  const double determinant = covariance.determinant();
  if (!covariance.allFinite() || covariance(0, 0) < 0.0 || covariance(1, 1) < 0.0 || !(determinant >= -1e-12)) {
    rejects.push_back({record, "bad_covariance", "its covariance is not finite or not positive semi-definite"});
    return std::nullopt;
  }
  Look look;
  look.position = position.head<2>();
  look.up = position.z();
  constexpr double kLeast = 1e-6;  // m^2: a millimetre; keeps an inverse
  look.covariance = covariance.trace() > 0.0 ? Mat2(0.5 * (covariance + covariance.transpose()))
                                             : Mat2(unknown_sigma * unknown_sigma * Mat2::Identity());
  look.covariance += kLeast * Mat2::Identity();
  return look;
}

}  // namespace

void ObstacleMapOptions::visit(base::OptionVisitor& v) {
  v.choice("memory", memory, {"as_mode", "paper", "robust"},
           "paper: the union of all objects; robust: association over time");
  v.real("gate-sigma", gate_sigma, 0.1, 100.0, "largest Mahalanobis distance of an object and an obstacle");
  v.real("max-gate-m", max_gate_m, 0.01, 1e3, "largest distance of an object and an obstacle");
  v.real("systematic-m", systematic_m, 0.0, 100.0, "1 sigma of what all looks have in common");
  v.real("unknown-sigma-m", unknown_sigma_m, 0.001, 100.0, "1 sigma of objects sent without covariance");
  v.real("class-penalty", class_penalty, 0.0, 1e3, "added to the squared distance where classes differ");
  v.real("merge-fraction", merge_fraction, 0.0, 10.0, "obstacles nearer than this part of their width are one");
  v.real("detection-probability", detection_probability, 0.01, 0.999, "of an object in view");
  v.real("false-probability", false_probability, 0.001, 0.99, "of a detection where there is nothing");
  v.real("confirm-probability", confirm_probability, 0.01, 0.9999, "obstacles are reported from here on");
  v.real("drop-probability", drop_probability, 0.01, 0.9999, "and until below this");
  v.real("clear-probability", clear_probability, 0.0001, 0.99, "obstacles are forgotten below");
  v.real("most-probability", most_probability, 0.5, 0.999999, "evidence grows no further");
  v.real("footprint-margin-m", footprint_margin_m, 0.0, 1e3, "objects so far inside the image count as missed");
  v.real("half-life-s", half_life_s, 0.0, 1e9, "of the evidence out of view; 0 = it stays");
  v.flag("motion", motion, "estimate the velocity of moving objects");
  v.real("motion-window-s", motion_window_s, 0.1, 1e3, "time over which a velocity is taken");
  v.real("min-speed-m-s", min_speed_m_s, 0.0, 100.0, "slower objects are at rest");
  v.real("max-speed-m-s", max_speed_m_s, 0.01, 1e3, "faster motion is taken for chance");
  v.real("motion-chi2", motion_chi2, 0.0, 1e6, "fall of squared residuals that makes an object moving");
  v.real("acceleration-m-s2", acceleration_m_s2, 0.0, 100.0, "1 sigma; widens the gate of moving objects");
  v.real("moving-timeout-s", moving_timeout_s, 0.0, 1e9, "moving objects not seen for longer are forgotten");
}

struct ObstacleMap::Impl {
  ObstacleMapOptions options;
  MotionRules rules;
  double hit = 0.0, miss = 0.0, confirm = 0.0, drop = 0.0, clear = 0.0, most = 0.0;
  std::int64_t next_id = 1;
  std::int64_t newest_ns = std::numeric_limits<std::int64_t>::min();
  std::vector<ObstacleTrack> tracks;  // ascending id
  std::set<std::pair<std::int64_t, std::uint32_t>> taken;

  [[nodiscard]] bool robust() const { return options.memory != "paper"; }

  [[nodiscard]] std::vector<Sighting> sightings(const survey::Packet& packet, PacketReport& report) const {
    std::vector<Sighting> result;
    for (std::size_t i = 0; i < packet.objects.size(); ++i) {
      const auto& object = packet.objects[i];
      const std::string record = "packet " + std::to_string(packet.sequence) + ", object " + std::to_string(i + 1);
      auto look = look_of(object.position, object.covariance, options.unknown_sigma_m, record, report.rejects);
      if (!look) continue;
      if (!std::isfinite(object.size_m) || object.size_m < 0.0 || !std::isfinite(object.height_m) ||
          object.height_m < 0.0) {
        report.rejects.push_back({record, "bad_size", "its size is not finite or negative"});
        continue;
      }
      look->width_m = object.size_m;
      look->height_m = object.height_m;
      look->score = std::isfinite(object.score) ? std::clamp(object.score, 0.0, 1.0) : 0.0;
      look->object_class = object.object_class;
      const auto kind = kind_of_class(object.object_class, options.classes).value_or(ObstacleKind::obstacle);
      result.push_back({std::move(*look), kind});
    }
    for (std::size_t i = 0; i < packet.vehicles.size(); ++i) {
      const std::string record = "packet " + std::to_string(packet.sequence) + ", vehicle " + std::to_string(i + 1);
      auto look = look_of(packet.vehicles[i].position, packet.vehicles[i].covariance, options.unknown_sigma_m, record,
                          report.rejects);
      if (!look) continue;
      look->score = 1.0;
      look->object_class = "ugv";
      result.push_back({std::move(*look), ObstacleKind::vehicle});
    }
    for (auto& sighting : result) sighting.look.time_ns = packet.capture_time_ns;
    return result;
  }

  // Squared Mahalanobis distance plus the logarithm of the volume; empty beyond the gate.
  [[nodiscard]] std::optional<double> cost(const Sighting& s, const ObstacleTrack& track) const {
    if (s.kind != track.kind) return std::nullopt;
    const double penalty = s.look.object_class == track.object_class() ? 0.0 : options.class_penalty;
    const double common = 2.0 * options.systematic_m * options.systematic_m;
    std::optional<double> best;
    const auto consider = [&](const Place& place) {
      const Vec2 d = s.look.position - place.position;
      if (!(d.norm() <= options.max_gate_m)) return;
      const Mat2 spread = place.covariance + s.look.covariance + common * Mat2::Identity();
      const double squared = d.dot(spread.inverse() * d);
      if (!(squared <= options.gate_sigma * options.gate_sigma)) return;
      const double value = squared + std::log(spread.determinant()) + penalty;
      if (!best || value < *best) best = value;
    };
    if (!track.moving) consider(track.at_rest());
    if (options.motion)
      if (const auto place = track.moved_to(s.look.time_ns, rules)) consider(*place);
    return best;
  }

  // Track of each sighting, or kUnassigned.
  [[nodiscard]] std::vector<std::size_t> associate(const std::vector<Sighting>& seen) const {
    struct Pair {
      std::size_t row, track;
      double cost;
    };
    std::vector<Pair> pairs;
    std::set<std::size_t> within;
    for (std::size_t i = 0; i < seen.size(); ++i)
      for (std::size_t t = 0; t < tracks.size(); ++t)
        if (const auto value = cost(seen[i], tracks[t])) {
          pairs.push_back({i, t, *value});
          within.insert(t);
        }
    const std::vector<std::size_t> columns(within.begin(), within.end());
    // A column of its own lets each row go without a track, at more than any pair within the gate costs, so that a
    // birth is never preferred to an obstacle that is there.
    double dearest = 0.0, cheapest = 0.0;
    for (const Pair& p : pairs) {
      dearest = std::max(dearest, p.cost);
      cheapest = std::min(cheapest, p.cost);
    }
    const double alone = dearest + (dearest - cheapest) + 1.0;
    const double never = static_cast<double>(seen.size() + 1) * (alone - cheapest + 1.0) + alone;
    const std::size_t width = columns.size() + seen.size();
    std::vector<double> costs(seen.size() * width, never);
    for (std::size_t i = 0; i < seen.size(); ++i) costs[i * width + columns.size() + i] = alone;
    for (const Pair& p : pairs) {
      const auto column =
          static_cast<std::size_t>(std::lower_bound(columns.begin(), columns.end(), p.track) - columns.begin());
      costs[p.row * width + column] = p.cost;
    }
    auto assigned = geometry::assign(costs, seen.size(), width);
    for (auto& column : assigned) column = column < columns.size() ? columns[column] : geometry::kUnassigned;
    return assigned;
  }

  void count_misses(const survey::Packet& packet, PacketReport& report) {
    if (packet.footprint.size() < 3) return;
    for (auto& track : tracks) {
      if (track.last_seen_ns >= packet.capture_time_ns) continue;
      const Place place = track.at(packet.capture_time_ns, rules);
      const double radius = 0.5 * track.width();
      if (!(depth_inside(packet.footprint, place.position) >= options.footprint_margin_m + radius)) continue;
      decay(track, packet.capture_time_ns);
      track.log_odds += miss;
      track.last_in_view_ns = std::max(track.last_in_view_ns, packet.capture_time_ns);
      ++track.misses;
      ++report.missed;
    }
  }

  [[nodiscard]] double faded(const ObstacleTrack& track, std::int64_t now_ns) const {
    if (!(options.half_life_s > 0.0) || now_ns <= track.last_in_view_ns) return track.log_odds;
    return track.log_odds * std::exp2(-kNs * static_cast<double>(now_ns - track.last_in_view_ns) / options.half_life_s);
  }
  void decay(ObstacleTrack& track, std::int64_t now_ns) const { track.log_odds = faded(track, now_ns); }

  void merge_doubles(std::int64_t capture_ns, PacketReport& report) {
    for (std::size_t i = 0; i < tracks.size(); ++i) {
      if (tracks[i].last_seen_ns != capture_ns) continue;
      for (std::size_t j = 0; j < tracks.size(); ++j) {
        // Two that one image showed apart are two.
        if (j == i || tracks[j].last_seen_ns == capture_ns || tracks[j].kind != tracks[i].kind || tracks[i].moving ||
            tracks[j].moving)
          continue;
        const double reach = options.merge_fraction * 0.5 * (tracks[i].width() + tracks[j].width());
        if (!((tracks[i].at_rest().position - tracks[j].at_rest().position).norm() < reach)) continue;
        const std::size_t kept = std::min(i, j), gone = std::max(i, j);
        tracks[kept].merge(tracks[gone]);
        tracks.erase(tracks.begin() + static_cast<std::ptrdiff_t>(gone));
        ++report.merged;
        i = kept;
        j = static_cast<std::size_t>(-1);  // from the first again
      }
    }
  }

  void settle() {
    for (auto& track : tracks) {
      if (track.log_odds >= confirm) track.confirmed = true;
      if (track.log_odds < drop) track.confirmed = false;
    }
  }

  void forget(PacketReport& report) {
    const auto gone = [&](const ObstacleTrack& track) {
      const double silent_s = kNs * static_cast<double>(newest_ns - track.last_seen_ns);
      return track.log_odds < clear || (track.moving && silent_s > options.moving_timeout_s);
    };
    report.cleared = static_cast<std::size_t>(std::count_if(tracks.begin(), tracks.end(), gone));
    tracks.erase(std::remove_if(tracks.begin(), tracks.end(), gone), tracks.end());
  }
};

ObstacleMap::ObstacleMap(ObstacleMapOptions options, std::int64_t first_id) : impl_(std::make_unique<Impl>()) {
  base::validate(base::bind_options(options), "obstacle map");
  impl_->rules = {options.motion,      options.motion_window_s,   options.min_speed_m_s, options.max_speed_m_s,
                  options.motion_chi2, options.acceleration_m_s2, options.systematic_m};
  impl_->hit = std::log(options.detection_probability / options.false_probability);
  impl_->miss = std::log((1.0 - options.detection_probability) / (1.0 - options.false_probability));
  impl_->confirm = log_odds(options.confirm_probability);
  impl_->drop = std::min(impl_->confirm, log_odds(options.drop_probability));
  impl_->clear = log_odds(options.clear_probability);
  impl_->most = log_odds(options.most_probability);
  impl_->next_id = first_id;
  impl_->options = std::move(options);
}
ObstacleMap::~ObstacleMap() = default;
ObstacleMap::ObstacleMap(ObstacleMap&&) noexcept = default;
ObstacleMap& ObstacleMap::operator=(ObstacleMap&&) noexcept = default;

PacketReport ObstacleMap::add(const survey::Packet& packet) {
  Impl& m = *impl_;
  PacketReport report;
  if (!m.taken.emplace(packet.capture_time_ns, packet.sequence).second) {
    report.rejects.push_back(
        {"packet " + std::to_string(packet.sequence), "duplicate_packet", "it was taken in before"});
    return report;
  }
  m.newest_ns = std::max(m.newest_ns, packet.capture_time_ns);
  const auto seen = m.sightings(packet, report);
  const std::vector<std::size_t> track_of =
      m.robust() ? m.associate(seen) : std::vector<std::size_t>(seen.size(), geometry::kUnassigned);
  for (std::size_t i = 0; i < seen.size(); ++i) {
    if (track_of[i] == geometry::kUnassigned) {
      m.tracks.emplace_back(m.next_id++, seen[i].kind, seen[i].look, m.rules);
      m.tracks.back().log_odds = std::min(m.hit, m.most);
      ++report.born;
    } else {
      auto& track = m.tracks[track_of[i]];
      m.decay(track, packet.capture_time_ns);
      track.add(seen[i].look, m.rules);
      track.log_odds = std::min(track.log_odds + m.hit, m.most);
      track.misses = 0;
      ++report.associated;
    }
  }
  if (m.robust()) {
    m.count_misses(packet, report);
    m.merge_doubles(packet.capture_time_ns, report);
    m.settle();
    m.forget(report);
  }
  return report;
}

std::vector<survey::Obstacle> ObstacleMap::obstacles(std::int64_t now_ns, bool confirmed) const {
  const Impl& m = *impl_;
  std::vector<survey::Obstacle> result;
  for (const auto& track : m.tracks) {
    if (m.robust()) {
      const double evidence = m.faded(track, now_ns);
      if (evidence < m.clear || (confirmed && !(track.confirmed && evidence >= m.drop))) continue;
      const double silent_s = kNs * static_cast<double>(now_ns - track.last_seen_ns);
      if (track.moving && silent_s > m.options.moving_timeout_s) continue;
    }
    result.push_back(track.record(m.rules));
  }
  return result;
}

}  // namespace cairn::ground
