#include "coverage/visibility_query.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "base/error.hpp"
#include "base/parallel.hpp"
#include "camera/projection.hpp"

namespace cairn::coverage {

using geometry::Vec3;

std::string_view name_of(Sight sight) {
  constexpr std::array<std::string_view, 3> kNames = {"seen", "out_of_frame", "occluded"};
  return kNames[static_cast<std::size_t>(sight)];
}

std::vector<PointSight> who_sees(const Vec3& point, const visibility::Scene& scene, const ViewSet& views,
                                 const CoverageOptions& options) {
  if (!point.allFinite()) throw base::Error(base::ErrorCode::invalid_argument, "the point is not finite");
  std::vector<PointSight> rows;
  rows.reserve(views.views.size());
  for (const View& view : views.views) {
    if (view.camera >= views.cameras.size())
      throw base::Error(base::ErrorCode::invalid_input, "a view names a camera that is not there")
          .record("frame " + std::to_string(view.frame.value));
    const survey::Camera& camera = views.cameras[view.camera];
    const Vec3 line = point - view.T_world_camera.translation;
    PointSight row;
    row.frame = view.frame;
    row.range_m = line.norm();
    const auto pixel = camera::project_world(camera, view.T_world_camera, point);
    if (pixel && camera::inside_image(camera, *pixel, options.frame_margin)) {
      row.pixel = *pixel;
      const double depth = view.T_world_camera.rotation.col(2).dot(line);
      constexpr double kMillimetres = 1000.0;
      // A pixel's solid angle is cos^3 / (fx fy); square to the line it covers range^2 times that.
      row.gsd_mm = kMillimetres * std::sqrt(depth * depth * depth / (row.range_m * camera.fx_px * camera.fy_px));
      const geometry::Ray ray{view.T_world_camera.translation, line / row.range_m};
      const auto hit = scene.cast({&ray, 1}, row.range_m * (1.0 - options.end_gap)).front();
      row.sight = hit.hit() ? Sight::occluded : Sight::seen;
      if (hit.hit()) row.blocked_at_m = hit.distance;
    }
    rows.push_back(row);
  }
  return rows;
}

std::vector<std::uint8_t> viewshed(const geometry::TriangleMesh& mesh, const visibility::Scene& scene, const Vec3& eye,
                                   double end_gap) {
  std::vector<std::uint8_t> seen(mesh.triangles.size(), 0);
  if (!eye.allFinite()) return seen;
  base::parallel_for(seen.size(), 4096, [&](std::size_t begin, std::size_t end) {
    std::vector<Vec3> targets;
    std::vector<std::size_t> facets;
    for (std::size_t f = begin; f < end; ++f) {
      const geometry::Triangle& t = mesh.triangles[f];
      const std::size_t count = mesh.vertices.size();
      if (t[0] >= count || t[1] >= count || t[2] >= count) continue;
      const Vec3 c = mesh.centroid(f);
      if (!(mesh.area_vector(f).dot(eye - c) > 0.0)) continue;
      targets.push_back(c);
      facets.push_back(f);
    }
    std::vector<std::uint8_t> blocked(targets.size(), 0);
    scene.blocked_from(eye, targets, blocked, end_gap);
    for (std::size_t i = 0; i < facets.size(); ++i) seen[facets[i]] = blocked[i] == 0 ? 1 : 0;
  });
  return seen;
}

}  // namespace cairn::coverage
