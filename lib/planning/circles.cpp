#include "planning/circles.hpp"

#include <algorithm>
#include <cmath>

#include "base/angle.hpp"
#include "base/error.hpp"
#include "base/number_text.hpp"
#include "camera/projection.hpp"
#include "planning/camera_aim.hpp"
#include "planning/cylinder_surface.hpp"
#include "visibility/scene.hpp"

namespace cairn::planning {
namespace {

using base::Error;
using base::ErrorCode;
using geometry::Vec3;
using geometry::VerticalCylinder;
using survey::Waypoint;

constexpr std::size_t kMostPoints = 120;
constexpr double kMostOverlap = 0.8;
constexpr std::size_t kMostCircles = 10'000;
constexpr std::size_t kSectors = 72, kRows = 12, kRings = 6;  // pieces of the cylinder that are looked at

double tangent(double degrees) {
  return std::tan(base::deg_to_rad(degrees));
}

// Heading of a camera on the circle at this azimuth of the axis.
double inward(double azimuth_deg) {
  return azimuth_deg + 180.0;
}

Vec3 on_circle(const geometry::Vec2& axis, double radius, double azimuth_deg, double up) {
  const double a = base::deg_to_rad(azimuth_deg);
  return {axis.x() + radius * std::sin(a), axis.y() + radius * std::cos(a), up};
}

MappingCircles lay_circles(const VerticalCylinder& cylinder, const survey::Camera& camera, const CircleOptions& options,
                           double start_deg, std::size_t points, double overlap) {
  MappingCircles result;
  result.radius_m = cylinder.radius + options.stand_off_m;
  result.points_a_circle = points;
  result.overlap = overlap;
  double azimuth = start_deg;
  for (const double up : circle_heights(cylinder, options, overlap)) {
    for (std::size_t i = 0; i <= points; ++i) {
      Waypoint w;
      const double at = azimuth + 360.0 * static_cast<double>(i) / static_cast<double>(points);
      w.position = on_circle(cylinder.axis, result.radius_m, at, up);
      w.heading_deg = inward(at);
      w.pitch_deg = -options.axis_deg;
      w.stop = i == 0 || i == points;
      w.photo = i < points;  // the last point closes the circle
      w.role = survey::WaypointRole::circle;
      w.group = static_cast<std::int64_t>(result.circles);
      result.waypoints.push_back(w);
      if (!w.photo) continue;
      survey::Frame image;
      image.id = survey::FrameId(static_cast<std::int64_t>(result.images.size()));
      image.camera = camera.id;
      image.T_world_camera = camera_pose(w.position, w.heading_deg, w.pitch_deg);
      result.images.push_back(image);
    }
    azimuth += 360.0;
    ++result.circles;
  }
  return result;
}

}  // namespace

std::string unfit(const VerticalCylinder& c) {
  if (!c.axis.allFinite() || !std::isfinite(c.bottom) || !std::isfinite(c.top) || !std::isfinite(c.radius))
    return "cylinder_not_finite";
  if (!(c.height() > 0.0)) return "cylinder_without_height";
  if (!(c.radius > 0.0)) return "cylinder_without_radius";
  return "";
}

std::vector<double> circle_heights(const VerticalCylinder& cylinder, const CircleOptions& options, double overlap) {
  const double upper = options.axis_deg - 0.5 * options.scan_deg, lower = options.axis_deg + 0.5 * options.scan_deg;
  if (!(upper > 0.0) || !(lower < 90.0))
    throw Error(ErrorCode::invalid_argument, "the scanned field of view must lie between the horizon and the vertical")
        .found(base::to_text(upper) + " to " + base::to_text(lower) + " deg below the horizon")
        .allowed("above 0, below 90 deg")
        .hint("Choose --axis-deg and --scan-deg so that axis - scan/2 > 0 and axis + scan/2 < 90");
  const double r_m = options.stand_off_m;
  const double step = r_m * (tangent(lower) - tangent(upper)) * (1.0 - overlap);
  const double last = cylinder.top + (cylinder.radius + r_m) * tangent(upper);
  const double first = cylinder.bottom + r_m * tangent(lower);
  std::vector<double> heights{first};
  while (heights.back() < last) {
    if (heights.size() == kMostCircles)
      throw Error(ErrorCode::invalid_argument, "too many circles for this cylinder")
          .found("height " + base::to_text(cylinder.height()) + " m, step " + base::to_text(step) + " m")
          .allowed("at most " + std::to_string(kMostCircles) + " circles")
          .hint("Choose a larger --stand-off-m");
    heights.push_back(first + step * static_cast<double>(heights.size()));
  }
  return heights;
}

CylinderCoverage cylinder_coverage(const VerticalCylinder& cylinder, const std::vector<survey::Frame>& images,
                                   const survey::Camera& camera, double scan_deg, std::int64_t views) {
  const CylinderSurface surface = cylinder_surface(cylinder, kSectors, kRows, kRings);
  const auto& mesh = surface.mesh;
  const visibility::Scene scene(mesh);
  const std::size_t n = mesh.triangles.size();
  std::vector<Vec3> centre(n), normal(n);
  std::vector<std::int64_t> seen(n, 0);
  for (std::size_t f = 0; f < n; ++f) {
    centre[f] = mesh.centroid(f);
    normal[f] = mesh.area_vector(f);
  }
  const double half_scan = scan_deg > 0.0 ? tangent(0.5 * scan_deg) : 0.0;
  std::vector<std::size_t> facets;
  std::vector<Vec3> targets;
  std::vector<std::uint8_t> blocked;
  for (const survey::Frame& image : images) {
    const auto T_camera_world = image.T_world_camera.inverse();
    const Vec3 eye = image.T_world_camera.translation;
    facets.clear();
    targets.clear();
    for (std::size_t f = 0; f < n; ++f) {
      if (normal[f].dot(eye - centre[f]) <= 0.0) continue;
      const Vec3 p = T_camera_world * centre[f];
      if (scan_deg > 0.0 && std::abs(p.y()) > half_scan * p.z()) continue;
      const auto pixel = camera::project(camera, p);
      if (!pixel || !camera::inside_image(camera, *pixel)) continue;
      facets.push_back(f);
      targets.push_back(centre[f]);
    }
    blocked.assign(targets.size(), 0);
    scene.blocked_from(eye, targets, blocked, 1e-3);
    for (std::size_t i = 0; i < facets.size(); ++i)
      if (blocked[i] == 0) ++seen[facets[i]];
  }
  CylinderCoverage coverage;
  double side = 0.0, top = 0.0;
  for (std::size_t f = 0; f < n; ++f) {
    const double area = normal[f].norm();
    const bool of_side = f < surface.side_facets;
    (of_side ? side : top) += area;
    if (seen[f] >= 1) (of_side ? coverage.side : coverage.top) += area;
    if (seen[f] >= views) (of_side ? coverage.side_wanted : coverage.top_wanted) += area;
  }
  for (double* share : {&coverage.side, &coverage.side_wanted}) *share /= side;
  for (double* share : {&coverage.top, &coverage.top_wanted}) *share /= top;
  return coverage;
}

MappingCircles mapping_circles(const VerticalCylinder& cylinder, const survey::Camera& camera,
                               const CircleOptions& options, double start_deg) {
  CircleOptions checked = options;
  base::validate(base::bind_options(checked), "mapping circles");
  if (const std::string reason = unfit(cylinder); !reason.empty())
    throw Error(ErrorCode::invalid_argument, "no circles can be flown about this cylinder")
        .found(reason)
        .allowed("finite, height and radius above 0");
  const FieldOfView view = field_of_view(camera);
  if (const double half = base::rad_to_deg(std::min(view.up, view.down)); half < 0.5 * options.scan_deg)
    throw Error(ErrorCode::invalid_argument, "the camera sees less than the scanned field of view")
        .found(base::to_fixed(2.0 * half, 2) + " deg")
        .allowed("at least --scan-deg " + base::to_text(options.scan_deg))
        .hint("Choose a smaller --scan-deg");
  const bool robust = options.mode == "robust";
  auto points = static_cast<std::size_t>(options.points);
  double overlap = robust ? options.vertical_overlap : 0.0;
  const std::int64_t views = robust ? options.views : 1;
  while (true) {
    MappingCircles circles = lay_circles(cylinder, camera, options, start_deg, points, overlap);
    circles.coverage = cylinder_coverage(cylinder, circles.images, camera, options.scan_deg, views);
    const double least = std::min(circles.coverage.side_wanted, circles.coverage.top_wanted);
    const bool full = points >= kMostPoints && overlap >= kMostOverlap;
    if (!robust || least >= options.coverage || full) return circles;
    // More images first; where they no longer help, more circles.
    if (points < kMostPoints) points = std::min(kMostPoints, points + std::max<std::size_t>(2, points / 5));
    else overlap = std::min(kMostOverlap, overlap + 0.2);
  }
}

std::vector<Waypoint> estimation_circle(const Vec3& centre, double search_up, const Vec3& from, double angle_deg,
                                        std::size_t points) {
  if (!(search_up > centre.z()) || !(angle_deg > 0.0 && angle_deg < 90.0) || points < 3 || !centre.allFinite() ||
      !from.allFinite())
    throw Error(ErrorCode::invalid_argument, "no estimation circle can be flown")
        .found("centre at " + base::to_text(centre.z()) + " m, search at " + base::to_text(search_up) + " m, " +
               base::to_text(angle_deg) + " deg, " + std::to_string(points) + " points")
        .allowed("search above the centre, 0 < angle < 90 deg, 3 points or more");
  const double radius = (search_up - centre.z()) / tangent(angle_deg);
  const double start = aim_at(centre, from, 0.0).heading_deg;
  std::vector<Waypoint> circle;
  for (std::size_t i = 0; i <= points; ++i) {
    Waypoint w;
    const double azimuth = start + 360.0 * static_cast<double>(i) / static_cast<double>(points);
    w.position = on_circle(centre.head<2>(), radius, azimuth, search_up);
    w.heading_deg = inward(azimuth);
    w.pitch_deg = -angle_deg;
    w.stop = i == 0 || i == points;
    w.photo = i < points;
    w.role = survey::WaypointRole::circle;
    circle.push_back(w);
  }
  return circle;
}

}  // namespace cairn::planning
