#include "pipeline/segment_las.hpp"

#include <algorithm>

#include "io/las.hpp"
#include "io/las_append.hpp"

namespace cairn::pipeline {
namespace {

using geometry::ScalarType;
using geometry::Vec3;
using segmentation::Label;

struct LabelledPoint {
  std::uint64_t point;
  std::uint32_t target;
  float probability;
};

std::vector<LabelledPoint> labelled_points(const TiledSegments& segments) {
  std::vector<LabelledPoint> points;
  for (const TiledObject& object : segments.objects)
    for (std::size_t i = 0; i < object.points.size(); ++i)
      points.push_back({object.points[i], object.target_id, object.probability[i]});
  std::sort(points.begin(), points.end(),
            [](const LabelledPoint& a, const LabelledPoint& b) { return a.point < b.point; });
  return points;
}

}  // namespace

TiledSegments segment_las_by_tiles(const std::filesystem::path& in, const std::filesystem::path& out,
                                   const SegmentTilesOptions& options, const LabelObject& label,
                                   const std::function<void(std::vector<Vec3>&)>& to_local, base::RunContext& ctx) {
  const io::LasReader reader(in);
  const PointSource source{reader.metadata().point_count, [&](std::uint64_t first, std::uint64_t n) {
                             auto points = reader.read(first, n, io::LasColumns::positions_only()).positions;
                             if (to_local) to_local(points);
                             return points;
                           }};
  TiledSegments segments = segment_tiles(source, options, label, ctx);
  const auto points = labelled_points(segments);
  const std::vector<io::LasAddition> additions = {{segmentation::kLabelColumn, ScalarType::u8, ""},
                                                  {segmentation::kTargetIdColumn, ScalarType::u32, ""},
                                                  {"probability", ScalarType::f32, "of the label"}};
  io::append_las_dimensions(in, out, additions, [&](std::uint64_t first, std::vector<std::vector<double>>& values) {
    ctx.check_stop();
    auto at = std::lower_bound(points.begin(), points.end(), first,
                               [](const LabelledPoint& p, std::uint64_t i) { return p.point < i; });
    for (std::size_t i = 0; i < values[0].size(); ++i) {
      const Label there = segments.labels[first + i];
      values[0][i] = static_cast<double>(there);
      values[1][i] = segmentation::kNoTarget;
      values[2][i] = there == Label::terrain ? 1.0 : 0.0;
      if (at == points.end() || at->point != first + i) continue;
      values[1][i] = at->target;
      values[2][i] = static_cast<double>(at->probability);
      ++at;
    }
  });
  return segments;
}

}  // namespace cairn::pipeline
