#include <GeographicLib/Constants.hpp>
#include <GeographicLib/LocalCartesian.hpp>
#include <cmath>

#include "base/error.hpp"
#include "base/number_text.hpp"
#include "geodesy/local_frame.hpp"

namespace cairn::geodesy {
namespace {

using geometry::Geodetic;
using geometry::Vec3;

void check(const Geodetic& position) {
  const auto refuse = [](std::string_view what, double found, std::string_view allowed) {
    throw base::Error(base::ErrorCode::crs_mismatch, std::string(what) + " out of range")
        .found(base::to_text(found))
        .allowed(allowed)
        .hint("Give latitude, longitude, height in degrees and metres, in that order");
  };
  if (!(std::abs(position.latitude_deg) <= 90.0)) refuse("latitude", position.latitude_deg, "-90 to 90");
  if (!(std::abs(position.longitude_deg) <= 180.0)) refuse("longitude", position.longitude_deg, "-180 to 180");
  if (!(std::abs(position.height_m) <= 20000.0)) refuse("height", position.height_m, "-20000 to 20000 m");
}

}  // namespace

struct LocalFrame::Impl {
  GeographicLib::LocalCartesian cartesian;
};

LocalFrame::LocalFrame(const Geodetic& origin) : origin_(origin) {
  check(origin);
  impl_ = std::make_shared<const Impl>(
      Impl{GeographicLib::LocalCartesian(origin.latitude_deg, origin.longitude_deg, origin.height_m)});
}

Vec3 LocalFrame::to_local(const Geodetic& position) const {
  Vec3 p = Vec3::Zero();
  impl_->cartesian.Forward(position.latitude_deg, position.longitude_deg, position.height_m, p.x(), p.y(), p.z());
  return p;
}

Geodetic LocalFrame::to_geodetic(const Vec3& p_world) const {
  Geodetic g;
  impl_->cartesian.Reverse(p_world.x(), p_world.y(), p_world.z(), g.latitude_deg, g.longitude_deg, g.height_m);
  return g;
}

std::string LocalFrame::raster_crs_wkt() const {
  // Transverse Mercator is conformal: its point scale at the origin is k0 times that on the
  // ellipsoid; distances at height h are longer by (R + h)/R with R the Gaussian radius.
  const double a = GeographicLib::Constants::WGS84_a();
  const double f = GeographicLib::Constants::WGS84_f();
  const double e2 = f * (2.0 - f);
  const double s = std::sin(origin_.latitude_deg * GeographicLib::Math::degree());
  const double gaussian_radius = a * std::sqrt(1.0 - e2) / (1.0 - e2 * s * s);
  const double k0 = 1.0 + origin_.height_m / gaussian_radius;
  const auto parameter = [](std::string_view name, double value, std::string_view unit, int code) {
    return "PARAMETER[\"" + std::string(name) + "\"," + base::to_text(value) + "," + std::string(unit) +
           ",ID[\"EPSG\"," + std::to_string(code) + "]],";
  };
  const std::string degree = "ANGLEUNIT[\"degree\",0.0174532925199433]";
  const std::string metre = "LENGTHUNIT[\"metre\",1]";
  return "PROJCRS[\"cairn local frame\",BASEGEOGCRS[\"WGS 84\",DATUM[\"World Geodetic System 1984\","
         "ELLIPSOID[\"WGS 84\",6378137,298.257223563," +
         metre + "]],PRIMEM[\"Greenwich\",0," + degree +
         "],ID[\"EPSG\",4326]],CONVERSION[\"local transverse Mercator\",METHOD[\"Transverse Mercator\","
         "ID[\"EPSG\",9807]]," +
         parameter("Latitude of natural origin", origin_.latitude_deg, degree, 8801) +
         parameter("Longitude of natural origin", origin_.longitude_deg, degree, 8802) +
         parameter("Scale factor at natural origin", k0, "SCALEUNIT[\"unity\",1]", 8805) +
         parameter("False easting", 0.0, metre, 8806) + "PARAMETER[\"False northing\",0," + metre +
         ",ID[\"EPSG\",8807]]],CS[Cartesian,2],AXIS[\"(E)\",east,ORDER[1]],AXIS[\"(N)\",north,ORDER[2]]," + metre + "]";
}

std::string LocalFrame::fingerprint() const {
  return "enu:" + base::to_fixed(origin_.latitude_deg, 9) + "," + base::to_fixed(origin_.longitude_deg, 9) + "," +
         base::to_fixed(origin_.height_m, 4);
}

}  // namespace cairn::geodesy
