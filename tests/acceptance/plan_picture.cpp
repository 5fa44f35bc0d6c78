#include "plan_picture.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <vector>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "camera/projection.hpp"
#include "io/image.hpp"
#include "io/raster.hpp"
#include "io/survey_folder.hpp"

namespace cairn::acceptance {
namespace {

using geometry::Grid;
using geometry::Vec2;
using geometry::Vec3;

Grid<float> heights_of(const std::filesystem::path& path) {
  for (const auto& band : io::read_raster(path).bands)
    if (const auto* values = std::get_if<Grid<float>>(&band.values)) return *values;
  throw base::Error(base::ErrorCode::invalid_input, "no band of heights").file(path.string());
}

double median_of(const Grid<float>& heights) {
  std::vector<float> known;
  for (const float h : heights.values)
    if (std::isfinite(h)) known.push_back(h);
  if (known.empty()) return 0.0;
  std::nth_element(known.begin(), known.begin() + static_cast<std::ptrdiff_t>(known.size() / 2), known.end());
  return static_cast<double>(known[known.size() / 2]);
}

}  // namespace

PlanPicture plan_picture(const std::filesystem::path& survey_folder, const std::filesystem::path& surface,
                         double cell_m) {
  const auto survey = io::read_survey(survey_folder);
  const auto heights = heights_of(surface);
  const double median = median_of(heights);
  const auto& g = heights.geometry;
  PlanPicture picture;
  picture.geometry = geometry::covering_grid({g.west, g.south()}, {g.east(), g.north}, cell_m);
  const auto& p = picture.geometry;
  std::vector<std::uint8_t> rgb(3 * p.cells(), 255);
  // The frame of each cell first, so that one photograph is in memory at a time.
  std::map<std::size_t, std::vector<std::pair<std::size_t, Vec2>>> wanted;
  for (std::size_t i = 0; i < p.cells(); ++i) {
    const Vec2 place = p.centre(i / p.columns, i % p.columns);
    const auto cell = g.cell_at(place);
    const float height = cell ? heights.at(cell->first, cell->second) : std::numeric_limits<float>::quiet_NaN();
    const Vec3 point(place.x(), place.y(), std::isfinite(height) ? static_cast<double>(height) : median);
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
