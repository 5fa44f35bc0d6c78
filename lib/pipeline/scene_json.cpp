#include "pipeline/scene_json.hpp"

#include <cmath>
#include <optional>
#include <string>
#include <utility>

#include "base/angle.hpp"
#include "base/error.hpp"
#include "geometry/rigid_transform.hpp"
#include "io/json.hpp"
#include "io/mesh.hpp"
#include "pipeline/json_fields.hpp"
#include "pipeline/scene_drive.hpp"
#include "pipeline/scene_terrain.hpp"

namespace cairn::pipeline {
namespace fs = std::filesystem;
namespace {

using base::Error;
using base::ErrorCode;
using geometry::Vec2;
using geometry::Vec3;
using namespace simulation;

constexpr std::int64_t kSceneSchemaVersion = 1;
constexpr int kMaxExtends = 8;

void vec3(JsonFields& f, std::string_view name, Vec3& value) {
  if (const auto v = f.reals(name, 3)) value = {(*v)[0], (*v)[1], (*v)[2]};
}

void pair(JsonFields& f, std::string_view name, double& lo, double& hi) {
  if (const auto v = f.reals(name, 2)) {
    lo = (*v)[0];
    hi = (*v)[1];
  }
}

// Members of this file before those of the one it extends.
io::Json merged(const fs::path& path, int depth, std::vector<fs::path>& files) {
  files.push_back(path);
  io::Json json = io::read_json(path);
  if (!json.is_object()) throw Error(ErrorCode::invalid_input, "a scene is a JSON object").file(path.string());
  const auto* extends = json.find("extends");
  if (extends == nullptr) return json;
  if (!extends->is_string() || depth >= kMaxExtends)
    throw Error(ErrorCode::invalid_input,
                extends->is_string() ? "scenes extend one another too often" : "the wrong kind of value")
        .file(path.string())
        .record("extends")
        .found(extends->dump(0))
        .allowed(extends->is_string() ? "at most 8 in a row" : "a file's name");
  const io::Json lower = merged(path.parent_path() / extends->as_string(), depth + 1, files);
  for (const auto& [key, value] : lower.as_object())
    if (json.find(key) == nullptr) json.set(key, value);
  return json;
}

class SceneReader {
 public:
  SceneReader(fs::path folder, std::vector<fs::path>& files) : scene_files_{std::move(folder), files} {}

  Scene read(const io::Json& json) {
    JsonFields f(json, "");
    f.require("schema_version");
    std::int64_t version = 0;
    f.integer("schema_version", version);
    if (version != kSceneSchemaVersion)
      f.fail("schema_version", "unknown schema version", std::to_string(version), std::to_string(kSceneSchemaVersion));
    std::string ignored;
    f.text("extends", ignored);
    f.text("name", scene_.name);
    f.text("description", scene_.description);
    f.object("origin", [&](JsonFields& o) { origin(o); });
    f.require("terrain");
    f.object("terrain", [&](JsonFields& t) { scene_.terrain = read_scene_terrain(t, scene_files_); });
    f.list("objects", [&](JsonFields& o) { object(o); });
    cameras(f);
    f.object("mount", [&](JsonFields& m) {
      m.real("gamma_deg", scene_.mount.gamma_deg);
      m.real("yaw_deg", scene_.mount.yaw_deg);
    });
    f.require("flights");
    f.list("flights", [&](JsonFields& o) { flight(o); });
    f.object("pose_noise", [&](JsonFields& n) { pose_noise(n); });
    f.object("detector", [&](JsonFields& d) { detector(d); });
    f.list("confusions", [&](JsonFields& c) {
      Confusion confusion;
      c.require("of");
      c.require("as");
      c.require("probability");
      c.text("of", confusion.of);
      c.text("as", confusion.as);
      c.real("probability", confusion.probability);
      scene_.confusions.push_back(confusion);
    });
    f.object("products", [&](JsonFields& p) { products(p); });
    f.object("drive", [&](JsonFields& d) { scene_.drive = read_scene_drive(d); });
    f.finish();
    return std::move(scene_);
  }

 private:
  void origin(JsonFields& o) {
    o.require("latitude_deg");
    o.require("longitude_deg");
    o.real("latitude_deg", scene_.origin.latitude_deg);
    o.real("longitude_deg", scene_.origin.longitude_deg);
    o.real("height_m", scene_.origin.height_m);
    if (!(std::abs(scene_.origin.latitude_deg) <= 90.0))
      o.fail("latitude_deg", "off the globe", std::to_string(scene_.origin.latitude_deg), "-90 to 90");
    if (!(std::abs(scene_.origin.longitude_deg) <= 180.0))
      o.fail("longitude_deg", "off the globe", std::to_string(scene_.origin.longitude_deg), "-180 to 180");
  }

  void cameras(JsonFields& f) {
    const auto* list = f.raw("cameras");
    if (list == nullptr) {
      scene_.cameras.push_back(r200_camera());
      return;
    }
    if (!list->is_array()) f.fail("cameras", "the wrong kind of value", list->dump(0), "a list");
    std::size_t index = 0;
    for (const auto& item : list->as_array()) {
      JsonFields c(item, "cameras[" + std::to_string(index) + "]");
      survey::Camera camera;
      if (c.has("preset")) {
        static_cast<void>(c.choice("preset", {"r200"}));
        camera = r200_camera();
        c.text("name", camera.name);
        c.finish();
      } else {
        camera = given_camera(c);
      }
      camera.id = survey::CameraId(static_cast<std::int64_t>(++index));
      scene_.cameras.push_back(camera);
    }
  }

  static survey::Camera given_camera(JsonFields& c) {
    survey::Camera camera;
    c.text("name", camera.name);
    const std::vector<std::string_view> models{"pinhole", "radial", "brown", "fisheye"};
    if (const auto model = c.choice("model", models)) camera.model = *survey::camera_model_from(models[*model]);
    c.require("width_px");
    c.require("height_px");
    c.integer("width_px", camera.width_px);
    c.integer("height_px", camera.height_px);
    camera.cx_px = 0.5 * static_cast<double>(camera.width_px);
    camera.cy_px = 0.5 * static_cast<double>(camera.height_px);
    std::optional<double> hfov;
    c.real("hfov_deg", hfov);
    if (hfov && c.has("fx_px")) c.fail("hfov_deg", "two ways to say the same", "hfov_deg and fx_px", "one of them");
    if (hfov && !(*hfov > 0.0 && *hfov < 180.0))
      c.fail("hfov_deg", "out of range", std::to_string(*hfov), "more than 0, less than 180");
    if (hfov) camera.fx_px = 0.5 * static_cast<double>(camera.width_px) / std::tan(base::deg_to_rad(0.5 * *hfov));
    else c.require("fx_px");
    c.real("fx_px", camera.fx_px);
    camera.fy_px = camera.fx_px;
    c.real("fy_px", camera.fy_px);
    for (const auto& [name, value] : std::initializer_list<std::pair<const char*, double*>>{{"cx_px", &camera.cx_px},
                                                                                            {"cy_px", &camera.cy_px},
                                                                                            {"k1", &camera.k1},
                                                                                            {"k2", &camera.k2},
                                                                                            {"k3", &camera.k3},
                                                                                            {"k4", &camera.k4},
                                                                                            {"p1", &camera.p1},
                                                                                            {"p2", &camera.p2}})
      c.real(name, *value);
    c.finish();
    return camera;
  }

  void object(JsonFields& o) {
    ObjectSpec spec;
    o.require("class");
    o.require("shape");
    o.text("name", spec.name);
    o.text("class", spec.object_class);
    o.flag("sought", spec.sought);
    o.text("material", spec.material);
    spec.seed = scene_.objects.size() + 1;
    o.seed("seed", spec.seed);
    if (const auto p = o.reals("position", 2)) spec.position = Vec2((*p)[0], (*p)[1]);
    o.real("up_m", spec.up_m);
    o.real("sink_m", spec.sink_m);
    o.object("scatter", [&](JsonFields& s) {
      Scatter scatter;
      s.require("area");
      s.integer("count", scatter.count);
      s.area("area", scatter.area);
      s.real("spacing_m", scatter.spacing_m);
      pair(s, "size_share", scatter.size_share_lo, scatter.size_share_hi);
      s.real("max_slope_deg", scatter.max_slope_deg);
      spec.scatter = scatter;
    });
    o.object("shape", [&](JsonFields& s) { shape(s, spec.shape); });
    scene_.objects.push_back(std::move(spec));
  }

  void shape(JsonFields& s, ShapeSpec& spec) {
    s.require("kind");
    const std::vector<std::string_view> kinds{"sphere", "ellipsoid", "box", "cylinder", "cone", "rock", "tree", "mesh"};
    spec.kind = static_cast<ShapeKind>(*s.choice("kind", kinds));
    if (spec.kind == ShapeKind::mesh) spec.size_m = Vec3::Zero();
    vec3(s, "size_m", spec.size_m);
    s.real("azimuth_deg", spec.azimuth_deg);
    s.real("tilt_deg", spec.tilt_deg);
    s.real("irregularity", spec.irregularity);
    s.text("family", spec.family);
    s.real("pedestal_height_m", spec.pedestal_height_m);
    s.real("pedestal_radius_m", spec.pedestal_radius_m);
    s.real("foot_share", spec.foot_share);
    s.real("contact_share", spec.contact_share);
    std::int64_t pads = spec.contact_pads;
    s.integer("contact_pads", pads);
    if (pads < 1 || pads > 5) s.fail("contact_pads", "out of range", std::to_string(pads), "1 to 5");
    spec.contact_pads = static_cast<int>(pads);
    s.real("contact_gap_m", spec.contact_gap_m);
    s.real("edge_m", spec.edge_m);
    std::string file;
    s.text("file", file);
    if (file.empty() != (spec.kind != ShapeKind::mesh))
      s.fail("file", file.empty() ? "a mesh has no file" : "only a mesh has a file", file.empty() ? "nothing" : file,
             "a file with kind mesh");
    if (!file.empty()) {
      spec.mesh = io::read_mesh(scene_files_.resolve(file)).mesh;
      if (const auto rpy = s.reals("rotation_rpy_deg", 3)) rotate(spec.mesh, *rpy);
    }
  }

  // R = Rz(yaw) Ry(pitch) Rx(roll), as SDF and URDF write poses.
  static void rotate(geometry::TriangleMesh& mesh, const std::vector<double>& rpy_deg) {
    const geometry::Mat3 rotation = geometry::axis_rotation(Vec3::UnitZ(), base::deg_to_rad(rpy_deg[2])) *
                                    geometry::axis_rotation(Vec3::UnitY(), base::deg_to_rad(rpy_deg[1])) *
                                    geometry::axis_rotation(Vec3::UnitX(), base::deg_to_rad(rpy_deg[0]));
    for (Vec3& v : mesh.vertices) v = rotation * v;
  }

  void flight(JsonFields& f) {
    Flight flight;
    f.require("kind");
    flight.kind = static_cast<FlightKind>(*f.choice("kind", {"lawn_mower", "orbit", "waypoints"}));
    f.text("camera", flight.camera);
    f.real("height_m", flight.height_m);
    if (const auto reference = f.choice("height_reference", {"world", "mean_ground", "ground"}))
      flight.height_reference = static_cast<HeightReference>(*reference);
    f.real("speed_m_s", flight.speed_m_s);
    f.real("turn_rate_deg_s", flight.turn_rate_deg_s);
    if (f.has("photo_spacing_m") && !f.has("rate_hz")) flight.rate_hz = 0.0;
    f.real("rate_hz", flight.rate_hz);
    f.real("photo_spacing_m", flight.photo_spacing_m);
    f.real("gamma_deg", flight.gamma_deg);
    f.real("heading_deg", flight.heading_deg);
    f.flag("record_transit", flight.record_transit);
    switch (flight.kind) {
      case FlightKind::lawn_mower: lawn_mower(f, flight); break;
      case FlightKind::orbit:
        f.text("about", flight.about);
        vec3(f, "centre", flight.centre);
        if (f.has("about") == f.has("centre"))
          f.fail("about", "an orbit needs one centre", f.has("about") ? "about and centre" : "neither about nor centre",
                 "one of the two");
        f.real("radius_m", flight.radius_m);
        f.real("gamma_0_deg", flight.gamma_0_deg);
        f.real("turns", flight.turns);
        f.flag("clockwise", flight.clockwise);
        f.flag("aim_at_centre", flight.aim_at_centre);
        break;
      case FlightKind::waypoints: waypoints(f, flight); break;
    }
    scene_.flights.push_back(std::move(flight));
  }

  static void lawn_mower(JsonFields& f, Flight& flight) {
    f.require("area");
    f.area("area", flight.area);
    f.real("lane_azimuth_deg", flight.lane_azimuth_deg);
    f.real("lane_spacing_m", flight.lane_spacing_m);
    f.real("side_overlap", flight.side_overlap);
    f.object("circles", [&](JsonFields& c) {
      EstimationCircles circles;
      c.real("seen_s", circles.seen_s);
      c.real("gamma_0_deg", circles.gamma_0_deg);
      c.real("turns", circles.turns);
      c.flag("clockwise", circles.clockwise);
      c.flag("record_transit", circles.record_transit);
      flight.circles = circles;
    });
  }

  static void waypoints(JsonFields& f, Flight& flight) {
    f.require("points");
    const auto* list = f.raw("points");
    const std::string allowed = "a list of [east, north, up]";
    if (!list->is_array()) f.fail("points", "the wrong kind of value", list->dump(0), allowed);
    for (const auto& item : list->as_array()) {
      if (!item.is_array() || item.size() != 3) f.fail("points", "this is no point", item.dump(0), allowed);
      for (const auto& number : item.as_array())
        if (!number.is_number()) f.fail("points", "this is no point", item.dump(0), allowed);
      flight.waypoints.push_back(item.as_vec3());
    }
  }

  void products(JsonFields& f) {
    Products& p = scene_.products;
    f.flag("images", p.images);
    f.flag("depth", p.depth);
    f.flag("masks", p.masks);
    f.flag("meshes", p.meshes);
    f.text("image_format", p.image_format);
    f.object("cloud", [&](JsonFields& c) { cloud(c); });
    f.object("render", [&](JsonFields& r) {
      r.integer("samples", p.render.samples);
      r.real("far_m", p.render.far_m);
      r.real("image_noise", p.render.image_noise);
    });
    f.object("lighting", [&](JsonFields& l) {
      l.real("sun_azimuth_deg", p.lighting.sun_azimuth_deg);
      l.real("sun_elevation_deg", p.lighting.sun_elevation_deg);
      l.flag("shadows", p.lighting.shadows);
    });
    f.object("depth_noise", [&](JsonFields& n) {
      n.real("quadratic", p.depth_noise.quadratic);
      n.real("nearest_m", p.depth_noise.nearest_m);
      n.real("farthest_m", p.depth_noise.farthest_m);
      n.real("edge_hole", p.depth_noise.edge_hole);
      n.real("patch_hole", p.depth_noise.patch_hole);
    });
  }

  void cloud(JsonFields& f) {
    CloudOptions c;
    f.real("spacing_m", c.spacing_m);
    f.real("noise_m", c.noise_m);
    f.real("waviness_m", c.waviness_m);
    f.real("waviness_length_m", c.waviness_length_m);
    f.real("outlier_share", c.outlier_share);
    f.real("contact_width_m", c.contact_width_m);
    f.real("margin_m", c.margin_m);
    f.integer("min_views", c.min_views);
    f.real("max_incidence_deg", c.max_incidence_deg);
    f.real("max_range_m", c.max_range_m);
    f.integer("views", scene_.products.cloud_views);
    scene_.products.cloud = c;
  }

  void pose_noise(JsonFields& f) {
    PoseNoise& n = scene_.pose_noise;
    f.real("white_xy_m", n.white_xy_m);
    f.real("white_z_m", n.white_z_m);
    f.real("constant_xy_m", n.constant_xy_m);
    f.real("constant_z_m", n.constant_z_m);
    f.real("walk_xy_m_sqrt_s", n.walk_xy_m_sqrt_s);
    f.real("walk_z_m_sqrt_s", n.walk_z_m_sqrt_s);
    f.real("attitude_deg", n.attitude_deg);
    f.real("attitude_correlation_s", n.attitude_correlation_s);
    f.real("attitude_constant_deg", n.attitude_constant_deg);
  }

  void detector(JsonFields& f) {
    Detector& d = scene_.detector;
    f.real("jitter_px", d.jitter_px);
    f.real("jitter_share", d.jitter_share);
    f.real("miss_rate", d.miss_rate);
    f.real("miss_run_frames", d.miss_run_frames);
    f.real("min_visible_share", d.min_visible_share);
    f.real("min_inside_share", d.min_inside_share);
    f.real("min_size_px", d.min_size_px);
    f.texts("blind_to", d.blind_to);
    f.real("false_per_image", d.false_per_image);
    pair(f, "false_size_px", d.false_size_lo_px, d.false_size_hi_px);
    f.object("score", [&](JsonFields& s) {
      s.real("mean", d.score_mean);
      s.real("sigma", d.score_sigma);
    });
    f.object("false_score", [&](JsonFields& s) {
      s.real("mean", d.false_score_mean);
      s.real("sigma", d.false_score_sigma);
    });
    f.list("clutter", [&](JsonFields& c) {
      Clutter clutter;
      c.integer("count", clutter.count);
      if (const auto p = c.reals("position", 2)) clutter.position = Vec2((*p)[0], (*p)[1]);
      c.area("area", clutter.area);
      c.real("size_m", clutter.size_m);
      c.real("hit_probability", clutter.hit_probability);
      c.real("sector_deg", clutter.sector_deg);
      c.real("azimuth_deg", clutter.azimuth_deg);
      c.text("class", clutter.object_class);
      d.clutter.push_back(clutter);
    });
  }

  SceneFiles scene_files_;
  Scene scene_;
};

Scene read(const fs::path& path, std::vector<fs::path>& files) {
  const io::Json json = merged(path, 0, files);
  try {
    Scene scene = SceneReader(path.parent_path(), files).read(json);
    if (scene.name.empty()) scene.name = path.stem().string();
    validate(scene);
    return scene;
  } catch (Error& error) {
    // A value out of range is a fault of the file, not of the command line.
    if (error.code() != ErrorCode::invalid_argument) {
      error.default_file(path.string());
      if (error.file() != path.string()) error.in("scene " + path.string());
      throw;
    }
    throw Error(ErrorCode::invalid_input, error.message())
        .file(path.string())
        .record(error.record())
        .found(error.found())
        .allowed(error.allowed());
  }
}

}  // namespace

Scene read_scene(const fs::path& path) {
  std::vector<fs::path> files;
  return read(path, files);
}

std::vector<fs::path> scene_files(const fs::path& path) {
  std::vector<fs::path> files;
  static_cast<void>(read(path, files));
  return files;
}

}  // namespace cairn::pipeline
