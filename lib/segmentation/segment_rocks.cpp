#include "segmentation/segment_rocks.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "base/number_text.hpp"
#include "base/parallel.hpp"
#include "segmentation/find_rocks.hpp"
#include "segmentation/patch_graph.hpp"
#include "segmentation/plan_index.hpp"

namespace cairn::segmentation {
namespace {

using geometry::Vec2;
using geometry::Vec3;

constexpr double kThinSeat = 4.0;    // spacing around the rock over that on it: beyond, the seat cannot be told
constexpr double kTakenShare = 0.5;  // of a rock's points: more that belong to another make it a duplicate
constexpr double kRing = 0.4;        // m of surroundings beyond the margin, as segment_patch takes them

struct Attempt {
  std::vector<std::size_t> near;  // points of the patch
  PatchResult patch;
  bool tried = false;
};

// Whether the cloud shows enough of a rock and its surroundings for the crease between them.
bool dense_enough(std::span<const Vec3> points, const RockTarget& target, double radius, double margin,
                  double height_spacings) {
  std::vector<Vec3> inside, around;
  double low = 1e300, high = -1e300;
  for (const Vec3& p : points) {
    const double d = (p.head<2>() - target.centre).norm();
    if (d <= radius) inside.push_back(p), high = std::max(high, p.z());
    else if (d > radius + margin) around.push_back(p), low = std::min(low, p.z());
  }
  if (inside.size() < 500 || around.size() < 50) return false;
  const double spacing = point_spacing(inside), outside = point_spacing(around);
  return spacing > 0.0 && high - low >= height_spacings * spacing && outside <= kThinSeat * spacing;
}

}  // namespace

void SegmentRocksOptions::visit(base::OptionVisitor& visitor) {
  visitor.choice("method", method, {"auto", "crease", "height"},
                 "by the crease at the foot, by height above the ground, or as the cloud's density allows");
  visitor.real("dense-height-spacings", dense_height_spacings, 1.0, 1000.0,
               "auto: the crease is sought where the rock is this many spacings high");
  cut.visit(visitor);
  patch.visit(visitor);
}

RockCuts segment_rocks(const geometry::PointCloud& cloud, const std::vector<RockTarget>& targets,
                       const RockGuidance& guidance, const SegmentRocksOptions& options, base::RunContext& ctx) {
  RockCuts by_height = cut_rocks(cloud, targets, options.cut, ctx);
  by_height.probability.assign(cloud.size(), 0.0F);
  for (std::size_t i = 0; i < cloud.size(); ++i)
    if (by_height.labels[i] != Label::unlabelled) by_height.probability[i] = 0.5F;
  if (options.method == "height") return by_height;

  std::vector<const RockTarget*> ordered;
  for (const auto& t : targets) ordered.push_back(&t);
  std::sort(ordered.begin(), ordered.end(), [](const auto* a, const auto* b) { return a->id < b->id; });
  const PlanIndex index(cloud.positions);
  const double margin = options.patch.margin_m;
  const auto radius_of = [&](const RockTarget& t) {
    return std::min(options.cut.max_radius_m, t.radius > 0.0 ? t.radius : options.cut.default_radius_m);
  };
  std::vector<Attempt> attempts(ordered.size());
  base::parallel_for(ordered.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      const RockTarget& target = *ordered[k];
      Attempt& attempt = attempts[k];
      const double radius = radius_of(target);
      attempt.near = index.within(target.centre, radius + margin + kRing);
      std::vector<Vec3> points;
      points.reserve(attempt.near.size());
      for (const std::size_t i : attempt.near) points.push_back(cloud.positions[i]);
      PatchInput in;
      in.points = points;
      in.centre = target.centre;
      in.radius = radius;
      in.low = target.low, in.high = target.high;
      for (const auto& pick : guidance.picks)
        if ((pick.position.head<2>() - target.centre).norm() <= radius + margin) in.picks.push_back(pick);
      if (const auto found = guidance.contacts.find(target.id.value); found != guidance.contacts.end())
        in.contact = found->second;
      for (const auto* other : ordered)
        if (other != &target && (other->centre - target.centre).norm() < radius + radius_of(*other))
          in.others.push_back({other->centre, radius_of(*other)});
      const bool wanted = options.method == "crease" || !in.picks.empty() || !in.contact.empty();
      if (!wanted && !dense_enough(points, target, radius, margin, options.dense_height_spacings)) continue;
      attempt.tried = true;
      attempt.patch = segment_patch(in, options.patch);
    }
  });
  ctx.check_stop();

  RockCuts cuts;
  cuts.labels.assign(cloud.size(), Label::unlabelled);
  cuts.target_ids.assign(cloud.size(), kNoTarget);
  cuts.probability.assign(cloud.size(), 0.0F);
  for (std::size_t k = 0; k < ordered.size(); ++k) {
    const RockTarget& target = *ordered[k];
    const Attempt& attempt = attempts[k];
    const std::string record = "target " + std::to_string(target.id.value);
    const auto cut = std::find_if(by_height.rocks.begin(), by_height.rocks.end(),
                                  [&](const RockCut& r) { return r.target == target.id; });
    if (attempt.tried && attempt.patch.found()) {
      const PatchResult& patch = attempt.patch;
      std::vector<std::size_t> rock;
      std::size_t taken = 0;
      for (std::size_t j = 0; j < attempt.near.size(); ++j)
        if (patch.labels[j] == Label::rock) {
          rock.push_back(attempt.near[j]);
          taken += cuts.labels[attempt.near[j]] == Label::rock;
        }
      if (rock.empty() || static_cast<double>(taken) > kTakenShare * static_cast<double>(rock.size())) {
        cuts.rejects.push_back({record, "duplicate_of_target", "most of its points belong to another target"});
        continue;
      }
      RockCut made;
      made.target = target.id;
      made.object_class = target.object_class;
      made.ground = patch.ground;
      made.threshold = 0.0;
      made.method = "crease";
      made.contact = patch.contact;
      made.concavity = patch.concavity;
      made.noise = patch.noise;
      made.notes = patch.notes;
      std::vector<Vec3> points;
      for (std::size_t j = 0; j < attempt.near.size(); ++j) {
        const std::size_t i = attempt.near[j];
        const Label label = patch.labels[j];
        if (label == Label::unlabelled) continue;
        // What an earlier rock has stays; its terrain and that of this one agree.
        if (cuts.target_ids[i] != kNoTarget) continue;
        if (label == Label::terrain && cuts.labels[i] != Label::unlabelled) continue;
        cuts.labels[i] = label;
        cuts.probability[i] = patch.probability[j];
        if (label != Label::terrain) cuts.target_ids[i] = static_cast<std::uint32_t>(target.id.value);
        if (label == Label::rock) made.points.push_back(i), points.push_back(cloud.positions[i]);
      }
      made.shape = describe_rock(points, patch.ground, 0.0);
      made.shape.spacing = patch.spacing;
      cuts.rocks.push_back(std::move(made));
      continue;
    }
    const bool firm = attempt.tried && (attempt.patch.reason == "two_points" || attempt.patch.reason == "planar" ||
                                        attempt.patch.reason == "not_a_surface");
    if (cut == by_height.rocks.end() || firm) {
      const auto why = std::find_if(by_height.rejects.begin(), by_height.rejects.end(),
                                    [&](const base::Reject& r) { return r.record == record; });
      if (firm || why == by_height.rejects.end())
        cuts.rejects.push_back({record, attempt.patch.reason, attempt.patch.message});
      else cuts.rejects.push_back(*why);
      continue;
    }
    std::size_t taken = 0;
    for (const std::size_t i : cut->points) taken += cuts.target_ids[i] != kNoTarget;
    if (static_cast<double>(taken) > kTakenShare * static_cast<double>(cut->points.size())) {
      cuts.rejects.push_back({record, "duplicate_of_target", "most of its points belong to another target"});
      continue;
    }
    RockCut kept = *cut;
    if (attempt.tried) kept.notes.push_back(attempt.patch.reason);
    if (const auto given = guidance.contacts.find(target.id.value); given != guidance.contacts.end())
      kept.contact = given->second;
    std::erase_if(kept.points, [&](std::size_t i) { return cuts.target_ids[i] != kNoTarget; });
    for (const std::size_t i : kept.points) {
      cuts.labels[i] = Label::rock;
      cuts.target_ids[i] = static_cast<std::uint32_t>(target.id.value);
      cuts.probability[i] = 0.5F;
    }
    cuts.rocks.push_back(std::move(kept));
  }
  // Terrain that only the cuts by height saw.
  for (std::size_t i = 0; i < cloud.size(); ++i)
    if (cuts.labels[i] == Label::unlabelled && by_height.labels[i] == Label::terrain)
      cuts.labels[i] = Label::terrain, cuts.probability[i] = 0.5F;
  return cuts;
}

std::vector<RockTarget> find_rock_targets(const geometry::PointCloud& cloud, base::RunContext& ctx) {
  const auto ground = filter_ground(cloud.positions, {}, ctx);
  std::vector<RockTarget> targets;
  for (const auto& candidate : find_rocks(cloud.positions, ground, PlanIndex(cloud.positions), {})) {
    RockTarget target;
    target.id = survey::TargetId(static_cast<std::int64_t>(targets.size()) + 1);
    target.object_class = "rock";
    target.centre = candidate.centre;
    target.radius = candidate.radius;
    target.low = candidate.ground_up, target.high = candidate.ground_up + candidate.height;
    targets.push_back(target);
  }
  return targets;
}

}  // namespace cairn::segmentation
