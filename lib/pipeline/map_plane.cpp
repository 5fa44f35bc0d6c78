#include "pipeline/map_plane.hpp"

#include <cmath>
#include <memory>

#include "base/error.hpp"
#include "geodesy/crs.hpp"
#include "geodesy/local_frame.hpp"

namespace cairn::pipeline {
namespace {

using base::Error;
using base::ErrorCode;
using geometry::Vec2;
using geometry::Vec3;

// Any frame serves to come from one CRS to another.
const geodesy::LocalFrame& zero_frame() {
  static const geodesy::LocalFrame frame({0.0, 0.0, 0.0});
  return frame;
}

bool same_plane(const std::string& a, const std::string& b) {
  if (a == b) return true;
  constexpr double kPerKilometre = 0.01;  // m
  try {
    const geodesy::CrsConverter from(a, zero_frame()), to(b, zero_frame());
    for (const Vec2& p : {Vec2(0.0, 0.0), Vec2(1000.0, 0.0), Vec2(0.0, 1000.0)}) {
      const Vec3 q = to.from_local(from.to_local(Vec3(p.x(), p.y(), 0.0)));
      if (!((q.head<2>() - p).norm() <= kPerKilometre)) return false;
    }
    return true;
  } catch (const Error&) {
    return false;  // a place outside the other CRS
  }
}

}  // namespace

void MapPlane::join_frame(const survey::Origin& origin, const std::filesystem::path& file) {
  const std::string crs = geodesy::LocalFrame(origin.position).raster_crs_wkt();
  join_crs(crs, file);
  if (!origin_) origin_ = origin;
}

void MapPlane::join_crs(const std::string& crs, const std::filesystem::path& file) {
  // An engineering CRS is somebody's plane, but not a place: raster_crs() of a map that is nowhere comes back so.
  if (crs.empty() || crs.rfind("ENGCRS", 0) == 0) return;
  if (crs_.empty()) {
    const auto info = geodesy::describe_crs(crs);
    if (info.geographic || std::abs(info.horizontal_unit_m - 1.0) > 1e-9)
      throw Error(ErrorCode::crs_mismatch, "a map whose coordinates are not metres")
          .file(file.string())
          .found(info.name)
          .allowed("a projected CRS in metres")
          .hint("Project it with gdalwarp -t_srs first");
    crs_ = crs;
    named_by_ = file;
    return;
  }
  if (same_plane(crs_, crs)) return;
  throw Error(ErrorCode::crs_mismatch, "the sources of the costmap lie in different frames")
      .file(file.string())
      .found(geodesy::describe_crs(crs).name)
      .allowed("the frame of " + named_by_.string() + ": " + geodesy::describe_crs(crs_).name)
      .hint("Project the raster with gdalwarp -t_srs to that CRS, or give files of one survey");
}

std::string MapPlane::raster_crs() const {
  if (!crs_.empty()) return crs_;
  return "ENGCRS[\"map frame\",EDATUM[\"origin of the map\"],CS[Cartesian,2],AXIS[\"x\",east,ORDER[1]],"
         "AXIS[\"y\",north,ORDER[2]],LENGTHUNIT[\"metre\",1]]";
}

std::optional<survey::Origin> MapPlane::place_of_zero() const {
  if (origin_ || crs_.empty()) return origin_;
  survey::Origin origin;
  try {
    origin.position = zero_frame().to_geodetic(geodesy::CrsConverter(crs_, zero_frame()).to_local(Vec3::Zero()));
  } catch (const Error&) {
    return std::nullopt;  // (0, 0) lies outside the CRS
  }
  origin.position.height_m = 0.0;
  origin.height_type = survey::HeightType::unknown;
  return origin;
}

MapPlane::Projection MapPlane::projection(const std::string& crs, const std::filesystem::path& file) const {
  if (crs_.empty())
    throw Error(ErrorCode::crs_mismatch, "nothing says where on Earth the map lies, and this layer does")
        .file(file.string())
        .hint("Give --survey, or put the map's .georeference.json beside it");
  if (crs.empty()) throw Error(ErrorCode::crs_mismatch, "a layer without a CRS").file(file.string());
  const geodesy::LocalFrame frame = origin_ ? geodesy::LocalFrame(origin_->position) : zero_frame();
  const auto in = std::make_shared<const geodesy::CrsConverter>(crs, frame);
  const auto out = origin_ ? nullptr : std::make_shared<const geodesy::CrsConverter>(crs_, frame);
  // Heights only matter by their share of the Earth's radius: those that a file does not have are the origin's.
  const double height = origin_ ? origin_->position.height_m : 0.0;
  return [in, out, height](std::vector<Vec3> points) {
    for (auto& p : points)
      if (p.z() == 0.0) p.z() = height;
    in->to_local(points);
    if (out) out->from_local(points);
    std::vector<Vec2> plane;
    plane.reserve(points.size());
    for (const auto& p : points) plane.emplace_back(p.x(), p.y());
    return plane;
  };
}

}  // namespace cairn::pipeline
