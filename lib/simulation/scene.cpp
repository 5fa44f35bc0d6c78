#include "simulation/scene.hpp"

#include <cmath>
#include <set>

#include "base/error.hpp"
#include "base/number_text.hpp"
#include "base/options.hpp"
#include "simulation/material.hpp"

namespace cairn::simulation {
namespace {

class Checker {
 public:
  void range(const std::string& where, double value, double lo, double hi) const {
    if (!(value >= lo && value <= hi))
      fail(where, base::to_text(value), base::to_text(lo) + " to " + base::to_text(hi));
  }
  void positive(const std::string& where, double value) const {
    if (!(value > 0.0 && std::isfinite(value))) fail(where, base::to_text(value), "> 0");
  }
  void not_negative(const std::string& where, double value) const {
    if (!(value >= 0.0 && std::isfinite(value))) fail(where, base::to_text(value), ">= 0");
  }
  void finite(const std::string& where, double value) const {
    if (!std::isfinite(value)) fail(where, base::to_text(value), "a finite number");
  }
  void area(const std::string& where, const geometry::Ring& ring) const {
    for (const auto& p : ring)
      if (!p.allFinite()) fail(where, "a point that is not finite", "finite numbers");
    if (ring.size() < 3 || std::abs(geometry::signed_area(ring)) < 1e-6)
      fail(where, std::to_string(ring.size()) + " points", "a polygon of at least 3 points and some area");
  }
  [[noreturn]] void fail(const std::string& where, const std::string& found, const std::string& allowed) const {
    throw base::Error(base::ErrorCode::invalid_argument, "the scene cannot be simulated")
        .record(where)
        .found(found)
        .allowed(allowed);
  }
};

std::string item(const char* list, std::size_t index) {
  return std::string(list) + "[" + std::to_string(index) + "]";
}

void check_terrain(const Terrain& terrain, const Checker& check) {
  constexpr double kMaxCells = 2.5e7;  // vertices of a ground
  if (terrain.kind == TerrainKind::grid && terrain.heights.values.empty())
    check.fail("terrain", "no heights", "a grid");
  if (terrain.kind == TerrainKind::mesh && terrain.mesh.triangles.empty())
    check.fail("terrain", "no triangles", "a mesh");
  if (terrain.kind != TerrainKind::fractal) return;
  for (int a = 0; a < 2; ++a) {
    check.range("terrain.min", terrain.min[a], -1e6, 1e6);
    check.range("terrain.max", terrain.max[a], -1e6, 1e6);
    check.positive("terrain.max - terrain.min", terrain.max[a] - terrain.min[a]);
  }
  check.positive("terrain.cell_m", terrain.cell_m);
  const geometry::Vec2 cells = (terrain.max - terrain.min) / terrain.cell_m;
  if (cells.x() * cells.y() > kMaxCells)
    check.fail("terrain.cell_m", base::to_text(cells.x() * cells.y()) + " cells", "at most 2.5e7 cells");
  check.range("terrain.base_up_m", terrain.base_up_m, -1e5, 1e5);
  check.range("terrain.slope_east", terrain.slope_east, -2.0, 2.0);
  check.range("terrain.slope_north", terrain.slope_north, -2.0, 2.0);
  check.range("terrain.relief_m", terrain.relief_m, 0.0, 1e4);
  check.positive("terrain.wavelength_m", terrain.wavelength_m);
  check.range("terrain.roughness", terrain.roughness, 0.0, 1.0);
}

void check_objects(const Scene& scene, const Checker& check) {
  std::set<std::string> names;
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    const ObjectSpec& o = scene.objects[i];
    const std::string at = item("objects", i);
    if (o.object_class.empty()) check.fail(at + ".class", "nothing", "a name");
    if (o.position.has_value() == o.scatter.has_value())
      check.fail(at, o.position ? "position and scatter" : "neither position nor scatter", "one of the two");
    if (!o.name.empty() && (o.scatter || !names.insert(o.name).second))
      check.fail(at + ".name", o.name, "a name of one object only");
    if (o.position && !o.position->allFinite()) check.fail(at + ".position", "not finite", "finite numbers");
    if (o.up_m) check.range(at + ".up_m", *o.up_m, -1e5, 1e5);
    check.range(at + ".sink_m", o.sink_m, 0.0, 1e3);
    if (!o.scatter) continue;
    check.range(at + ".scatter.count", static_cast<double>(o.scatter->count), 1.0, 1e6);
    check.area(at + ".scatter.area", o.scatter->area);
    check.range(at + ".scatter.spacing_m", o.scatter->spacing_m, 0.0, 1e4);
    check.positive(at + ".scatter.size_share[0]", o.scatter->size_share_lo);
    check.range(at + ".scatter.size_share[1]", o.scatter->size_share_hi, o.scatter->size_share_lo, 100.0);
    check.range(at + ".scatter.max_slope_deg", o.scatter->max_slope_deg, 0.0, 90.0);
  }
}

void check_cameras(const Scene& scene, const Checker& check) {
  if (scene.cameras.empty()) check.fail("cameras", "none", "at least one");
  for (std::size_t i = 0; i < scene.cameras.size(); ++i) {
    const auto& c = scene.cameras[i];
    const std::string at = item("cameras", i);
    check.range(at + ".width_px", static_cast<double>(c.width_px), 1.0, 100000.0);
    check.range(at + ".height_px", static_cast<double>(c.height_px), 1.0, 100000.0);
    check.positive(at + ".fx_px", c.fx_px);
    check.positive(at + ".fy_px", c.fy_px);
    for (const double value : {c.cx_px, c.cy_px, c.k1, c.k2, c.k3, c.k4, c.p1, c.p2}) check.finite(at, value);
    if (c.id.value != static_cast<std::int64_t>(i) + 1)
      check.fail(at + ".id", std::to_string(c.id.value), std::to_string(i + 1));
  }
  check.range("mount.gamma_deg", scene.mount.gamma_deg, 0.0, 90.0);
  check.range("mount.yaw_deg", scene.mount.yaw_deg, -360.0, 360.0);
}

void check_flight(const Scene& scene, const Flight& f, const std::string& at, const Checker& check) {
  bool known = f.camera.empty();
  for (const auto& camera : scene.cameras) known = known || camera.name == f.camera;
  if (!known) check.fail(at + ".camera", f.camera, "the name of one of the cameras");
  check.range(at + ".height_m", f.height_m, -1e5, 1e5);
  check.positive(at + ".speed_m_s", f.speed_m_s);
  check.positive(at + ".turn_rate_deg_s", f.turn_rate_deg_s);
  check.not_negative(at + ".rate_hz", f.rate_hz);
  check.not_negative(at + ".photo_spacing_m", f.photo_spacing_m);
  if ((f.rate_hz > 0.0) == (f.photo_spacing_m > 0.0))
    check.fail(at, f.rate_hz > 0.0 ? "rate_hz and photo_spacing_m" : "neither rate_hz nor photo_spacing_m",
               "one of the two");
  if (f.gamma_deg) check.range(at + ".gamma_deg", *f.gamma_deg, 0.0, 90.0);
  if (f.heading_deg) check.range(at + ".heading_deg", *f.heading_deg, -360.0, 360.0);
  if (f.kind == FlightKind::lawn_mower) {
    check.area(at + ".area", f.area);
    check.range(at + ".lane_azimuth_deg", f.lane_azimuth_deg, -360.0, 360.0);
    check.not_negative(at + ".lane_spacing_m", f.lane_spacing_m);
    check.range(at + ".side_overlap", f.side_overlap, 0.0, 0.95);
    if (f.circles) {
      check.not_negative(at + ".circles.seen_s", f.circles->seen_s);
      check.range(at + ".circles.gamma_0_deg", f.circles->gamma_0_deg, 1.0, 89.0);
      check.positive(at + ".circles.turns", f.circles->turns);
    }
  } else if (f.kind == FlightKind::orbit) {
    for (int a = 0; a < 3; ++a) check.finite(at + ".centre", f.centre[a]);
    check.not_negative(at + ".radius_m", f.radius_m);
    check.range(at + ".gamma_0_deg", f.gamma_0_deg, 1.0, 89.0);
    check.positive(at + ".turns", f.turns);
  } else {
    if (f.waypoints.empty()) check.fail(at + ".waypoints", "none", "at least one");
    for (const auto& p : f.waypoints)
      if (!p.allFinite()) check.fail(at + ".waypoints", "not finite", "finite numbers");
  }
}

void check_detector(const Detector& d, const Checker& check) {
  check.not_negative("detector.jitter_px", d.jitter_px);
  check.range("detector.jitter_share", d.jitter_share, 0.0, 1.0);
  check.range("detector.miss_rate", d.miss_rate, 0.0, 1.0);
  // A run of misses shorter than chance makes it would need runs of hits shorter than one frame.
  if (d.miss_rate < 1.0)
    check.range("detector.miss_run_frames", d.miss_run_frames, std::max(1.0, d.miss_rate / (1.0 - d.miss_rate)), 1e6);
  check.range("detector.min_visible_share", d.min_visible_share, 0.0, 1.0);
  check.range("detector.min_inside_share", d.min_inside_share, 0.0, 1.0);
  check.not_negative("detector.min_size_px", d.min_size_px);
  check.range("detector.false_per_image", d.false_per_image, 0.0, 100.0);
  check.positive("detector.false_size_px[0]", d.false_size_lo_px);
  check.range("detector.false_size_px[1]", d.false_size_hi_px, d.false_size_lo_px, 1e5);
  check.range("detector.score.mean", d.score_mean, 0.0, 1.0);
  check.range("detector.score.sigma", d.score_sigma, 0.0, 1.0);
  check.range("detector.false_score.mean", d.false_score_mean, 0.0, 1.0);
  check.range("detector.false_score.sigma", d.false_score_sigma, 0.0, 1.0);
  for (std::size_t i = 0; i < d.clutter.size(); ++i) {
    const Clutter& c = d.clutter[i];
    const std::string at = item("detector.clutter", i);
    check.range(at + ".count", static_cast<double>(c.count), 1.0, 1e5);
    if (c.position && c.count != 1) check.fail(at + ".count", std::to_string(c.count), "1 with a position");
    if (!c.position) check.area(at + ".area", c.area);
    check.positive(at + ".size_m", c.size_m);
    check.range(at + ".hit_probability", c.hit_probability, 0.0, 1.0);
    check.range(at + ".sector_deg", c.sector_deg, 1e-3, 360.0);
  }
}

void check_materials(const Scene& scene, const Checker& check) {
  const auto known = [&](const std::string& where, const std::string& name) {
    if (material_named(name, 0)) return;
    std::string names;
    for (const auto& material : material_names()) names += (names.empty() ? "" : ", ") + material;
    check.fail(where, name, names);
  };
  known("terrain.material", scene.terrain.material);
  for (std::size_t i = 0; i < scene.objects.size(); ++i)
    if (!scene.objects[i].material.empty()) known(item("objects", i) + ".material", scene.objects[i].material);
}

}  // namespace

survey::Camera r200_camera() {
  survey::Camera camera;
  camera.id = survey::CameraId(1);
  camera.name = "R200";
  camera.width_px = 640;
  camera.height_px = 480;
  camera.fx_px = camera.fy_px = 320.0 / std::tan(0.5 * 1.3962634);  // hfov 1.3962634 rad
  camera.cx_px = 320.0;
  camera.cy_px = 240.0;
  return camera;
}

void validate(const Scene& scene) {
  const Checker check;
  if (scene.drive) validate(*scene.drive);
  check_terrain(scene.terrain, check);
  check_objects(scene, check);
  check_cameras(scene, check);
  if (scene.flights.empty()) check.fail("flights", "none", "at least one");
  for (std::size_t i = 0; i < scene.flights.size(); ++i)
    check_flight(scene, scene.flights[i], item("flights", i), check);
  const PoseNoise& n = scene.pose_noise;
  for (const auto& [name, value] :
       std::initializer_list<std::pair<const char*, double>>{{"white_xy_m", n.white_xy_m},
                                                             {"white_z_m", n.white_z_m},
                                                             {"constant_xy_m", n.constant_xy_m},
                                                             {"constant_z_m", n.constant_z_m},
                                                             {"walk_xy_m_sqrt_s", n.walk_xy_m_sqrt_s},
                                                             {"walk_z_m_sqrt_s", n.walk_z_m_sqrt_s},
                                                             {"attitude_deg", n.attitude_deg},
                                                             {"attitude_correlation_s", n.attitude_correlation_s},
                                                             {"attitude_constant_deg", n.attitude_constant_deg}})
    check.range(std::string("pose_noise.") + name, value, 0.0, 1e3);
  check_detector(scene.detector, check);
  for (std::size_t i = 0; i < scene.confusions.size(); ++i)
    check.range(item("confusions", i) + ".probability", scene.confusions[i].probability, 0.0, 1.0);
  check_materials(scene, check);
  Products products = scene.products;
  base::validate(base::bind_options(products.render), "simulate, products.render");
  base::validate(base::bind_options(products.depth_noise), "simulate, products.depth_noise");
  if (products.cloud) base::validate(base::bind_options(*products.cloud), "simulate, products.cloud");
  check.range("products.cloud.views", static_cast<double>(products.cloud_views), 0.0, 1e6);
  if (scene.products.image_format != "jpg" && scene.products.image_format != "png")
    check.fail("products.image_format", scene.products.image_format, "jpg or png");
}

}  // namespace cairn::simulation
