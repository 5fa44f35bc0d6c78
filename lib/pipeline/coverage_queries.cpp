#include "pipeline/coverage_queries.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "base/number_text.hpp"
#include "coverage/visibility_query.hpp"
#include "io/csv.hpp"
#include "io/raster.hpp"

namespace cairn::pipeline {
namespace fs = std::filesystem;
namespace {

using geometry::Vec3;

std::vector<double> numbers(const std::string& text) {
  std::vector<double> result;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    const auto value = base::parse_real(text.substr(begin, end - begin));
    if (!value || !std::isfinite(*value)) return {};
    result.push_back(*value);
    begin = end + 1;
  }
  return result;
}

io::Json position(const Vec3& p) {
  return io::Json::object({{"east_m", p.x()}, {"north_m", p.y()}, {"up_m", p.z()}});
}

void set_known(io::Json& json, const char* name, double value) {
  if (std::isfinite(value)) json.set(name, value);
}

}  // namespace

std::vector<Vec3> parse_points(const std::vector<std::string>& texts, const AuditedSurface& surface,
                               const visibility::Scene& scene, double above) {
  std::vector<Vec3> points;
  for (const std::string& text : texts) {
    const std::vector<double> n = numbers(text);
    if (n.size() != 2 && n.size() != 3)
      throw base::Error(base::ErrorCode::invalid_argument, "a point is not understood")
          .found(text)
          .allowed("EAST,NORTH or EAST,NORTH,UP in metres");
    if (n.size() == 3) {
      points.emplace_back(n[0], n[1], n[2]);
      continue;
    }
    const geometry::Box3 box = surface.mesh.bounds();
    const double sky = box.empty() ? 0.0 : box.max.z() + 1.0;
    // A ray straight down an edge may slip between its two facets: then a millimetre beside it.
    constexpr double kBeside = 1e-3;  // m
    const std::array<geometry::Ray, 3> down = {
        geometry::Ray{Vec3(n[0], n[1], sky), -Vec3::UnitZ()},
        geometry::Ray{Vec3(n[0] + kBeside, n[1] + 0.3 * kBeside, sky), -Vec3::UnitZ()},
        geometry::Ray{Vec3(n[0] - 0.6 * kBeside, n[1] - kBeside, sky), -Vec3::UnitZ()}};
    const auto hits = scene.cast(down);
    const auto found = std::find_if(hits.begin(), hits.end(), [](const visibility::Hit& h) { return h.hit(); });
    const visibility::Hit hit = found == hits.end() ? visibility::Hit{} : *found;
    if (!hit.hit())
      throw base::Error(base::ErrorCode::invalid_input, "there is no surface at a point")
          .found(text)
          .hint("Give its height as a third number.");
    points.emplace_back(n[0], n[1], sky - hit.distance + above);
  }
  return points;
}

io::Json answer_points(const fs::path& out, const std::vector<Vec3>& points, const visibility::Scene& scene,
                       const CoverageViews& views, const coverage::CoverageOptions& options) {
  io::Json file = io::Json::array(), summary = io::Json::array();
  for (const Vec3& point : points) {
    io::Json rows = io::Json::array();
    std::size_t seen = 0;
    for (const coverage::PointSight& sight : coverage::who_sees(point, scene, views.set, options)) {
      io::Json row = io::Json::object({{"frame_id", sight.frame.value},
                                       {"sight", std::string(coverage::name_of(sight.sight))},
                                       {"range_m", sight.range_m}});
      set_known(row, "x_px", sight.pixel.x());
      set_known(row, "y_px", sight.pixel.y());
      set_known(row, "gsd_mm", sight.gsd_mm);
      set_known(row, "blocked_at_m", sight.blocked_at_m);
      seen += sight.sight == coverage::Sight::seen ? 1 : 0;
      rows.push(std::move(row));
    }
    io::Json item = position(point);
    item.set("seen_by", seen);
    summary.push(item);
    item.set("frames", std::move(rows));
    file.push(std::move(item));
  }
  base::write_file(out / "points.json",
                   io::Json::object({{"schema_version", 1}, {"points", std::move(file)}}).dump() + "\n");
  return summary;
}

io::Json answer_viewsheds(const fs::path& out, const std::vector<Vec3>& eyes, const AuditedSurface& surface,
                          const visibility::Scene& scene, double end_gap, base::RunContext& ctx) {
  std::vector<std::int64_t> seen_from(surface.mesh.triangles.size(), 0);
  io::Json summary = io::Json::array();
  for (const Vec3& eye : eyes) {
    ctx.check_stop();
    const auto seen = coverage::viewshed(surface.mesh, scene, eye, end_gap);
    double area = 0.0;
    for (std::size_t f = 0; f < seen.size(); ++f) {
      if (seen[f] == 0) continue;
      ++seen_from[f];
      const double a = surface.mesh.area_vector(f).norm();
      if (std::isfinite(a)) area += a;
    }
    io::Json item = position(eye);
    item.set("seen_area_m2", area);
    summary.push(std::move(item));
  }
  io::CsvWriter csv(out / "viewshed.csv", {"facet", "seen_from"});
  for (std::size_t f = 0; f < seen_from.size(); ++f)
    csv.cell(static_cast<std::uint64_t>(f)).cell(seen_from[f]).end_row();
  csv.finish();
  if (surface.grid && !surface.crs.empty()) {
    geometry::Grid<float> grid(*surface.grid, std::numeric_limits<float>::quiet_NaN());
    for (std::size_t f = 0; f < surface.facet_cell.size(); ++f) {
      float& cell = grid.values[surface.facet_cell[f]];
      const auto value = static_cast<float>(seen_from[f]);
      cell = std::isnan(cell) ? value : std::min(cell, value);
    }
    io::write_cog(out / "viewshed.tif",
                  {{"seen_from", "", "eyes that see the surface, least of the cell's facets", grid, std::nullopt}},
                  surface.crs);
  }
  return summary;
}

}  // namespace cairn::pipeline
