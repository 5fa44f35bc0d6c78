#include "pipeline/plan_site.hpp"

#include <algorithm>

#include "base/error.hpp"
#include "base/number_text.hpp"
#include "geodesy/crs.hpp"
#include "io/vector.hpp"
#include "pipeline/audited_surface.hpp"

namespace cairn::pipeline {

using base::Error;
using base::ErrorCode;
using geometry::Geodetic;

survey::Camera plan_camera(const PlanCameraOptions& options) {
  survey::Camera camera;
  camera.id = survey::CameraId(1);
  camera.name = "planned";
  camera.width_px = options.width_px;
  camera.height_px = options.height_px;
  camera.fx_px = camera.fy_px = options.focal_px;
  camera.cx_px = 0.5 * static_cast<double>(options.width_px);
  camera.cy_px = 0.5 * static_cast<double>(options.height_px);
  return camera;
}

Geodetic GeographicArea::centre() const {
  Geodetic low = rings.front().front(), high = low;
  for (const auto& ring : rings)
    for (const Geodetic& p : ring) {
      low.latitude_deg = std::min(low.latitude_deg, p.latitude_deg);
      low.longitude_deg = std::min(low.longitude_deg, p.longitude_deg);
      high.latitude_deg = std::max(high.latitude_deg, p.latitude_deg);
      high.longitude_deg = std::max(high.longitude_deg, p.longitude_deg);
    }
  return {0.5 * (low.latitude_deg + high.latitude_deg), 0.5 * (low.longitude_deg + high.longitude_deg), 0.0};
}

planning::Area GeographicArea::in(const geodesy::LocalFrame& frame) const {
  planning::Area area;
  for (const auto& ring : rings) {
    geometry::Ring& local = area.emplace_back();
    for (Geodetic p : ring) {
      // At the frame's own height east and north are those of the ground plan.
      p.height_m = frame.origin().height_m;
      local.emplace_back(frame.to_local(p).head<2>());
    }
  }
  return area;
}

GeographicArea read_area(const std::filesystem::path& path) {
  GeographicArea area;
  const geodesy::LocalFrame zero({0.0, 0.0, 0.0});
  for (const io::ForeignLayer& layer : io::read_vector(path)) {
    if (layer.kind != io::GeometryKind::polygon) continue;
    if (layer.crs.empty())
      throw Error(ErrorCode::crs_mismatch, "the area declares no coordinate reference system").file(path.string());
    const geodesy::CrsConverter converter(layer.crs, zero, {geodesy::Heights::keep_datum, true});
    for (const auto& feature : layer.features)
      for (const auto& part : feature.parts)
        for (const auto& ring : part) {
          auto& to = area.rings.emplace_back();
          for (const geometry::Vec3& p : ring)
            to.push_back(zero.to_geodetic(converter.to_local(geometry::Vec3(p.x(), p.y(), 0.0))));
          // Files repeat the first vertex, some read without it.
          if (to.size() > 1 && to.front() == to.back()) to.pop_back();
        }
  }
  if (area.rings.empty())
    throw Error(ErrorCode::invalid_input, "the area has no polygon")
        .file(path.string())
        .allowed("a polygon in GeoJSON, GeoPackage or Shapefile");
  return area;
}

planning::SurfaceHeights read_surface_heights(const std::filesystem::path& terrain, const geodesy::LocalFrame& frame,
                                              double cell_m, base::RunContext& ctx) {
  if (terrain.empty()) return planning::SurfaceHeights(0.0);
  const AuditedSurface surface = read_audited_surface(terrain, frame, ctx);
  ctx.check_stop();
  return planning::SurfaceHeights(planning::highest_of(surface.mesh, surface.grid ? surface.grid->cell : cell_m));
}

double parse_duration(const std::string& text) {
  double factor = 1.0;
  std::string_view number = text;
  for (const auto& [unit, seconds] : {std::pair<std::string_view, double>{"min", 60.0}, {"h", 3600.0}, {"s", 1.0}})
    if (number.ends_with(unit)) {
      number.remove_suffix(unit.size());
      factor = seconds;
      break;
    }
  const auto value = base::parse_real(number);
  if (!value || !(*value > 0.0 && *value <= 1e6))
    throw Error(ErrorCode::invalid_argument, "a duration is not understood").found(text).allowed("15min, 900s, 0.5h");
  return factor * *value;
}

}  // namespace cairn::pipeline
