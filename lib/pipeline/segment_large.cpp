#include "pipeline/segment_large.hpp"

#include <algorithm>
#include <array>

#include "io/cloud.hpp"
#include "io/las.hpp"
#include "pipeline/segment_las.hpp"

namespace cairn::pipeline {
namespace {

using geometry::Vec3;
using segmentation::Label;
using segmentation::RockTarget;

constexpr std::uint64_t kWholeBytesPerPoint = 160;  // of a cloud that is segmented at once
constexpr double kSurroundings = 0.5;               // m beyond what the cuts look at

ObjectLabels segment_object(const ObjectPatch& patch, const SegmentOptions& options) {
  geometry::PointCloud shape;
  shape.positions.assign(patch.points.begin(), patch.points.end());
  RockTarget target;
  target.id = survey::TargetId(0);
  target.object_class = "rock";
  target.centre = patch.object->centre;
  target.radius = patch.object->radius;
  base::RunContext quiet;
  auto cuts = segmentation::segment_rocks(shape, {target}, {}, options.rocks, quiet);
  ObjectLabels said;
  if (cuts.rocks.empty()) {
    said.reason = cuts.rejects.empty() ? "not_above_ground" : cuts.rejects.front().reason;
    said.message = cuts.rejects.empty() ? "" : cuts.rejects.front().message;
    return said;
  }
  said.labels = std::move(cuts.labels);
  said.probability = std::move(cuts.probability);
  said.record = std::move(cuts.rocks.front());
  return said;
}

}  // namespace

bool goes_by_tile(const SegmentFiles& in, const SegmentOptions& options, const base::RunContext& ctx) {
  if (!in.targets.empty() || !in.picks.empty() || !in.contact.empty()) return false;
  if (options.keep != "all" || options.intensity_labels) return false;
  if (io::recognise_cloud(in.cloud) != io::CloudFormat::las) return false;
  if (options.tile_m > 0.0) return true;
  return ctx.memory_limit_bytes > 0 &&
         io::LasReader(in.cloud).metadata().point_count > ctx.memory_limit_bytes / kWholeBytesPerPoint;
}

LargeSegments segment_large(const SegmentFiles& in, const std::filesystem::path& out_las,
                            const std::function<Vec3(const Vec3&)>& forth, const SegmentOptions& options,
                            base::RunContext& ctx) {
  SegmentTilesOptions tiles;
  tiles.tile_m = options.tile_m;
  tiles.patch_margin_m = options.rocks.cut.margin_m + options.rocks.cut.annulus_width_m + kSurroundings;
  auto segments = segment_las_by_tiles(
      in.cloud, out_las, tiles, [&](const ObjectPatch& patch) { return segment_object(patch, options); },
      [&](std::vector<Vec3>& points) {
        for (Vec3& p : points) p = forth(p);
      },
      ctx);
  LargeSegments result;
  std::size_t with_contact = 0;
  std::array<std::size_t, 5> counts{};
  for (TiledObject& object : segments.objects) {
    RockTarget target;
    target.id = survey::TargetId(object.target_id);
    target.object_class = "rock";
    target.centre = object.candidate.centre;
    target.radius = object.candidate.radius;
    result.targets.push_back(target);
    if (!object.reason.empty()) {
      result.cuts.rejects.push_back({"target " + std::to_string(object.target_id), object.reason, object.message});
      continue;
    }
    auto rock = std::any_cast<segmentation::RockCut>(std::move(object.record));
    rock.target = target.id;
    rock.points.clear();
    for (std::size_t i = 0; i < object.points.size(); ++i)
      if (object.labels[i] == Label::rock) rock.points.push_back(object.points[i]);
    with_contact += !rock.contact.empty();
    result.cuts.rocks.push_back(std::move(rock));
  }
  for (const Label label : segments.labels) ++counts[static_cast<std::size_t>(label)];
  auto& outcome = result.outcome;
  outcome.rejects = result.cuts.rejects;
  outcome.summary = io::Json::object({{"points", segments.labels.size()},
                                      {"targets", result.targets.size()},
                                      {"rocks", result.cuts.rocks.size()},
                                      {"rocks_with_contact", with_contact},
                                      {"rejected", outcome.rejects.size()},
                                      {"rejected_by_reason", count_by_reason(outcome.rejects)},
                                      {"rock_points", counts[2]},
                                      {"pedestal_points", counts[3]},
                                      {"basal_contact_points", counts[4]},
                                      {"terrain_points", counts[1]},
                                      {"tiles", segments.tiles},
                                      {"tile_m", segments.tile_m},
                                      {"buffer_m", segments.buffer_m}});
  return result;
}

}  // namespace cairn::pipeline
