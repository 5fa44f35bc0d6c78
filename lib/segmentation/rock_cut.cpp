#include "segmentation/rock_cut.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <variant>

#include "base/error.hpp"
#include "base/number_text.hpp"
#include "base/parallel.hpp"
#include "geometry/kd_tree.hpp"
#include "segmentation/clusters.hpp"
#include "segmentation/plan_index.hpp"

namespace cairn::segmentation {
namespace {

using geometry::Vec2;
using geometry::Vec3;

constexpr std::size_t kSectors = 36;
constexpr std::size_t kThinGround = 6;  // of 8 sectors: fewer with ground points is worth a note

struct Cut {
  RockCut rock;
  std::vector<std::size_t> terrain;
};

base::Reject reject(const RockTarget& target, const char* reason, std::string message) {
  return {"target " + std::to_string(target.id.value), reason, std::move(message)};
}

std::size_t sector_of(const Vec2& d) {
  const double turn = (std::atan2(d.y(), d.x()) + std::numbers::pi) / (2.0 * std::numbers::pi);
  return std::min(kSectors - 1, static_cast<std::size_t>(turn * kSectors));
}

double median_spacing(std::span<const Vec3> points) {
  if (points.size() < 2) return 0.0;
  const geometry::KdTree tree(points);
  std::vector<double> distance;
  distance.reserve(points.size());
  for (const auto& p : points) distance.push_back(std::sqrt(tree.nearest(p, 2).back().squared_distance));
  const auto middle = distance.begin() + static_cast<std::ptrdiff_t>(distance.size() / 2);
  std::nth_element(distance.begin(), middle, distance.end());
  return *middle;
}

// Edge of the square that one point has to itself in plan.
double typical_spacing(std::size_t points, double radius) {
  return points == 0 ? radius : radius * std::sqrt(std::numbers::pi / static_cast<double>(points));
}

}  // namespace

RockShape describe_rock(std::span<const Vec3> points, const GroundPlane& ground, double threshold) {
  RockShape shape;
  if (points.empty()) return shape;
  shape.spacing = median_spacing(points);
  for (const auto& p : points) shape.height = std::max(shape.height, ground.height_above(p));
  Vec2 middle = Vec2::Zero();
  for (const auto& p : points) middle += p.head<2>();
  middle /= static_cast<double>(points.size());
  struct Sector {
    std::size_t count = 0;
    double rim = 0.0;                                         // farthest rock point in plan
    double lowest = std::numeric_limits<double>::infinity();  // height above ground
    double lowest_distance = 0.0;
    double half_distance = 0.0;  // farthest point of the upper half
    std::array<bool, 4> quarter{};
  };
  std::array<Sector, kSectors> sectors;
  for (const auto& p : points) {
    const Vec2 d = p.head<2>() - middle;
    const double h = ground.height_above(p);
    Sector& s = sectors[sector_of(d)];
    ++s.count;
    s.rim = std::max(s.rim, d.norm());
    if (h < s.lowest) s.lowest = h, s.lowest_distance = d.norm();
    if (h > 0.5 * shape.height) s.half_distance = std::max(s.half_distance, d.norm());
    const double quarter = std::floor(4.0 * std::clamp(h / shape.height, 0.0, 0.999));
    s.quarter[static_cast<std::size_t>(quarter)] = true;
  }
  std::size_t flanks = 0;
  for (std::size_t k = 0; k < kSectors; ++k) {
    const Sector& s = sectors[k];
    if (s.count == 0) continue;
    if (s.lowest < 0.5 * shape.height) ++flanks;
    const double angle = (static_cast<double>(k) + 0.5) / kSectors * 2.0 * std::numbers::pi - std::numbers::pi;
    ContactSample sample;
    // Seen from above alone, a wall shows as a slope or a gap; steep points at every height need a look from aside.
    const double run = std::abs(s.lowest_distance - s.half_distance);
    const bool steep = 0.5 * shape.height - s.lowest > std::tan(std::numbers::pi / 3.0) * run;
    sample.observed =
        s.quarter[0] && s.quarter[1] && s.quarter[2] && steep && s.lowest < threshold + 2.0 * shape.spacing;
    const Vec2 foot = middle + (sample.observed ? s.lowest_distance : s.rim) * Vec2(std::cos(angle), std::sin(angle));
    sample.position = {foot.x(), foot.y(), ground.up(foot)};
    shape.contact.push_back(sample);
  }
  shape.sides_seen_share = static_cast<double>(flanks) / kSectors;
  return shape;
}

namespace {

std::variant<Cut, base::Reject> cut_one(const geometry::PointCloud& cloud, const PlanIndex& index,
                                        const RockTarget& target, const RockCutOptions& options) {
  const double radius = std::min(options.max_radius_m, target.radius > 0.0 ? target.radius : options.default_radius_m);
  const double inner = radius + options.margin_m;
  const double outer = inner + options.annulus_width_m;
  const auto near = index.within(target.centre, outer);
  if (near.empty())
    return reject(target, "cloud_missing",
                  "no cloud point within " + base::to_fixed(outer, 2) + " m; the cloud does not reach this target");
  std::vector<std::size_t> inside;
  std::vector<Vec3> around;
  for (const std::size_t i : near)
    if ((cloud.positions[i].head<2>() - target.centre).norm() <= inner) inside.push_back(i);
    else around.push_back(cloud.positions[i]);
  if (inside.empty()) return reject(target, "no_points", "no cloud point within " + base::to_fixed(inner, 2) + " m");
  const auto ground = fit_ground(around, target.centre);
  if (!ground || around.size() < static_cast<std::size_t>(options.min_ground_points) || ground->sectors < 4)
    return reject(target, "ground_not_seen",
                  std::to_string(around.size()) + " points around the target in " +
                      std::to_string(ground ? ground->sectors : 0) + " of 8 sectors, " +
                      std::to_string(options.min_ground_points) + " in 4 needed");

  Cut cut;
  RockCut& rock = cut.rock;
  rock.target = target.id;
  rock.object_class = target.object_class;
  rock.ground = *ground;
  rock.threshold = std::max(options.min_height_m, options.noise_factor * ground->noise);
  if (ground->sectors < kThinGround) rock.notes.emplace_back("thin_ground");
  std::vector<std::size_t> high;
  std::vector<Vec3> high_points;
  for (const std::size_t i : inside)
    if (ground->height_above(cloud.positions[i]) > rock.threshold) {
      high.push_back(i);
      high_points.push_back(cloud.positions[i]);
    }
  if (high.empty())
    return reject(target, "not_above_ground",
                  "no point stands " + base::to_fixed(rock.threshold, 3) + " m above the ground (noise " +
                      base::to_fixed(ground->noise, 3) + " m)");

  const double tolerance = options.cluster_factor * typical_spacing(inside.size(), inner);
  const std::vector<std::size_t>* best = nullptr;
  std::size_t best_count = 0;
  const auto clusters = euclidean_clusters(high_points, tolerance);
  for (const auto& cluster : clusters) {
    const auto count = static_cast<std::size_t>(std::count_if(cluster.begin(), cluster.end(), [&](std::size_t k) {
      return (high_points[k].head<2>() - target.centre).norm() <= radius;
    }));
    if (count > best_count) best_count = count, best = &cluster;
  }
  if (best == nullptr)
    return reject(target, "not_above_ground", "what stands above the ground lies outside the target's radius");
  if (best->size() < static_cast<std::size_t>(options.min_points))
    return reject(target, "too_few_points",
                  std::to_string(best->size()) + " rock points, " + std::to_string(options.min_points) + " needed");

  std::vector<Vec3> points;
  bool at_border = false;
  for (const std::size_t k : *best) {
    rock.points.push_back(high[k]);
    points.push_back(high_points[k]);
    at_border = at_border || (high_points[k].head<2>() - target.centre).norm() > inner - 0.5 * tolerance;
  }
  if (at_border) rock.notes.emplace_back("touches_crop");
  rock.shape = describe_rock(points, *ground, rock.threshold);
  for (const std::size_t i : near)
    if (std::abs(ground->height_above(cloud.positions[i])) <= rock.threshold) cut.terrain.push_back(i);
  return cut;
}

}  // namespace

double RockShape::observed_share() const {
  const auto seen = std::count_if(contact.begin(), contact.end(), [](const ContactSample& c) { return c.observed; });
  return static_cast<double>(seen) / kSectors;
}

void RockCutOptions::visit(base::OptionVisitor& visitor) {
  visitor.real("default-radius-m", default_radius_m, 0.01, 100.0, "radius of targets without a bounding cylinder");
  visitor.real("max-radius-m", max_radius_m, 0.01, 100.0, "cylinders are cut down to this radius");
  visitor.real("margin-m", margin_m, 0.0, 10.0, "added to the radius of the cylinder");
  visitor.real("annulus-width-m", annulus_width_m, 0.05, 50.0, "width of the ring the ground is fitted on");
  visitor.real("min-height-m", min_height_m, 0.0, 10.0, "a rock point stands at least this above the ground");
  visitor.real("noise-factor", noise_factor, 0.0, 20.0, "and this many standard deviations of the ground");
  visitor.real("cluster-factor", cluster_factor, 0.5, 20.0, "points nearer than this many spacings belong together");
  visitor.integer("min-points", min_points, 4, 1'000'000, "fewer rock points: rejected");
  visitor.integer("min-ground-points", min_ground_points, 3, 1'000'000, "fewer ground points: rejected");
}

RockCuts cut_rocks(const geometry::PointCloud& cloud, const std::vector<RockTarget>& targets,
                   const RockCutOptions& options, base::RunContext& ctx) {
  for (const auto& t : targets)
    if (!t.centre.allFinite() || !std::isfinite(t.radius) || !t.id.valid() || t.id.value >= std::int64_t{kNoTarget})
      throw base::Error(base::ErrorCode::invalid_input, "a target to cut has no usable centre, radius or id")
          .record("target " + std::to_string(t.id.value));
  std::vector<const RockTarget*> ordered;
  for (const auto& t : targets) ordered.push_back(&t);
  std::sort(ordered.begin(), ordered.end(), [](const auto* a, const auto* b) { return a->id < b->id; });
  for (std::size_t i = 1; i < ordered.size(); ++i)
    if (ordered[i]->id == ordered[i - 1]->id)
      throw base::Error(base::ErrorCode::invalid_input, "two targets have one id")
          .record("target " + std::to_string(ordered[i]->id.value));

  const PlanIndex index(cloud.positions);
  std::vector<std::variant<Cut, base::Reject>> results(ordered.size());
  base::parallel_for(ordered.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) results[i] = cut_one(cloud, index, *ordered[i], options);
  });
  ctx.check_stop();

  RockCuts cuts;
  cuts.labels.assign(cloud.size(), Label::unlabelled);
  cuts.target_ids.assign(cloud.size(), kNoTarget);
  for (auto& result : results) {
    if (auto* why = std::get_if<base::Reject>(&result)) {
      cuts.rejects.push_back(std::move(*why));
      continue;
    }
    auto& cut = std::get<Cut>(result);
    const auto taken = std::find_if(cut.rock.points.begin(), cut.rock.points.end(),
                                    [&](std::size_t i) { return cuts.target_ids[i] != kNoTarget; });
    if (taken != cut.rock.points.end()) {
      cuts.rejects.push_back({"target " + std::to_string(cut.rock.target.value), "duplicate_of_target",
                              "its rock points belong to target " + std::to_string(cuts.target_ids[*taken])});
      continue;
    }
    for (const std::size_t i : cut.terrain)
      if (cuts.labels[i] == Label::unlabelled) cuts.labels[i] = Label::terrain;
    for (const std::size_t i : cut.rock.points) {
      cuts.labels[i] = Label::rock;
      cuts.target_ids[i] = static_cast<std::uint32_t>(cut.rock.target.value);
    }
    cuts.rocks.push_back(std::move(cut.rock));
  }
  return cuts;
}

void add_label_columns(geometry::PointCloud& cloud, const RockCuts& cuts) {
  auto& label = cloud.add_scalar(kLabelColumn, geometry::ScalarType::u8, "0 none 1 terrain 2 rock 3 pedest 4 contact");
  for (std::size_t i = 0; i < cloud.size(); ++i) label.values[i] = static_cast<double>(cuts.labels[i]);
  auto& target = cloud.add_scalar(kTargetIdColumn, geometry::ScalarType::u32, "rock instance; 4294967295 none");
  for (std::size_t i = 0; i < cloud.size(); ++i) target.values[i] = cuts.target_ids[i];
  if (cuts.probability.size() != cloud.size()) return;
  auto& sure = cloud.add_scalar(kProbabilityColumn, geometry::ScalarType::f32, "of the label, 0..1");
  for (std::size_t i = 0; i < cloud.size(); ++i) sure.values[i] = static_cast<double>(cuts.probability[i]);
}

}  // namespace cairn::segmentation
