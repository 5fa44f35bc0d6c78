#include "plan_picture.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <vector>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "camera/projection.hpp"
#include "geodesy/local_frame.hpp"
#include "io/image.hpp"
#include "io/raster.hpp"
#include "io/survey_folder.hpp"
#include "pipeline/terrain_height.hpp"

namespace cairn::acceptance {
namespace {

using geometry::Vec2;
using geometry::Vec3;

geometry::GridGeometry extent_of(const std::filesystem::path& path) {
  return io::read_raster(path).bands.at(0).geometry();
}

}  // namespace

PlanPicture plan_picture(const std::filesystem::path& survey_folder, const std::filesystem::path& surface,
                         double cell_m) {
  const auto survey = io::read_survey(survey_folder);
  const pipeline::TerrainHeight terrain(surface, geodesy::LocalFrame(survey.manifest.origin.position));
  const auto g = extent_of(surface);
  PlanPicture picture;
  picture.geometry = geometry::covering_grid({g.west, g.south()}, {g.east(), g.north}, cell_m);
  const auto& p = picture.geometry;
  std::vector<std::uint8_t> rgb(3 * p.cells(), 255);
  // The frame of each cell first, so that one photograph is in memory at a time.
  std::map<std::size_t, std::vector<std::pair<std::size_t, Vec2>>> wanted;
  double last_up = 0.0;
  for (std::size_t i = 0; i < p.cells(); ++i) {
    const Vec2 place = p.centre(i / p.columns, i % p.columns);
    const auto up = terrain.up(place.x(), place.y());
    if (up) last_up = *up;
    const Vec3 point(place.x(), place.y(), last_up);
    double nearest = std::numeric_limits<double>::infinity();
    std::size_t chosen = survey.frames.size();
    Vec2 pixel = Vec2::Zero();
    for (std::size_t k = 0; k < survey.frames.size(); ++k) {
      const auto& frame = survey.frames[k];
      const double distance = (frame.T_world_camera.translation.head<2>() - place).norm();
      if (frame.image.empty() || distance >= nearest) continue;
      const auto& camera = *survey.camera(frame.camera);
      const auto at = camera::project_world(camera, frame.T_world_camera, point);
      if (!at || !camera::inside_image(camera, *at, 0.01)) continue;
      nearest = distance;
      chosen = k;
      pixel = *at;
    }
    if (chosen < survey.frames.size()) wanted[chosen].emplace_back(i, pixel);
  }
  for (const auto& [k, cells] : wanted) {
    const auto& frame = survey.frames[k];
    const auto photo = io::read_colour_image(io::resolve_reference(frame.image, survey_folder));
    const double scale =
        static_cast<double>(photo.width_px) / static_cast<double>(survey.camera(frame.camera)->width_px);
    for (const auto& [cell, pixel] : cells) {
      const auto x =
          static_cast<std::size_t>(std::clamp(pixel.x() * scale, 0.0, static_cast<double>(photo.width_px - 1)));
      const auto y =
          static_cast<std::size_t>(std::clamp(pixel.y() * scale, 0.0, static_cast<double>(photo.height_px - 1)));
      for (std::size_t c = 0; c < 3; ++c) rgb[3 * cell + c] = photo.values[3 * (y * photo.width_px + x) + c];
    }
  }
  const auto file = std::filesystem::temp_directory_path() / "cairn_plan_picture.jpg";
  io::write_rgb_image(file, static_cast<std::int64_t>(p.columns), static_cast<std::int64_t>(p.rows), rgb, 80);
  picture.jpeg = base::read_file(file);
  std::filesystem::remove(file);
  return picture;
}

}  // namespace cairn::acceptance
