#include <algorithm>
#include <cmath>
#include <utility>

#include "camera/projection.hpp"
#include "io/vector.hpp"
#include "pipeline/coverage_products.hpp"
#include "report/layers.hpp"

namespace cairn::pipeline {
namespace {

std::optional<double> median_height(const geometry::TriangleMesh& surface) {
  std::vector<double> heights;
  for (const geometry::Vec3& v : surface.vertices)
    if (std::isfinite(v.z())) heights.push_back(v.z());
  if (heights.empty()) return std::nullopt;
  const auto middle = heights.begin() + static_cast<std::ptrdiff_t>(heights.size() / 2);
  std::nth_element(heights.begin(), middle, heights.end());
  return *middle;
}

}  // namespace

void write_coverage_layers(const std::filesystem::path& path, const CoverageViews& views,
                           const geometry::TriangleMesh& surface, const std::vector<survey::CoverageGap>& gaps) {
  report::LayerRecords records;
  records.origin = *views.origin;
  if (views.survey) {
    records.time_base = views.survey->manifest.time_base;
    records.frames = views.survey->frames;
  } else {
    for (const coverage::View& view : views.set.views) {
      survey::Frame frame;
      frame.id = view.frame;
      frame.camera = views.set.cameras[view.camera].id;
      frame.T_world_camera = view.T_world_camera;
      records.frames.push_back(std::move(frame));
    }
  }
  records.gaps = gaps;
  records.ground_up_m = median_height(surface);
  if (records.ground_up_m)
    for (const coverage::View& view : views.set.views)
      records.footprints.push_back(
          camera::footprint(views.set.cameras[view.camera], view.T_world_camera, *records.ground_up_m));
  std::vector<io::Layer> layers = report::build_layers(records);
  std::erase_if(layers, [](const io::Layer& layer) {
    return layer.name != "frames" && layer.name != "footprints" && layer.name != "gaps";
  });
  io::write_geopackage(path, layers);
}

}  // namespace cairn::pipeline
