#include "support/sample_report.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <map>
#include <numbers>
#include <sstream>
#include <string>
#include <vector>

#include "base/angle.hpp"
#include "base/number_text.hpp"
#include "base/random.hpp"
#include "camera/projection.hpp"
#include "geometry/mass_properties.hpp"

namespace cairn::testing {
namespace {

using geometry::Vec2;
using geometry::Vec3;
using Row = std::map<std::string, std::string>;

std::vector<Row> read_table(const std::filesystem::path& path) {
  std::ifstream in(path);
  if (!in) throw std::runtime_error("cannot read " + path.string());
  const auto cells = [](const std::string& line) {
    std::vector<std::string> out;
    std::stringstream stream(line);
    for (std::string cell; std::getline(stream, cell, ',');) out.push_back(cell);
    return out;
  };
  std::string line;
  std::getline(in, line);
  const std::vector<std::string> names = cells(line);
  std::vector<Row> rows;
  while (std::getline(in, line)) {
    const std::vector<std::string> values = cells(line);
    Row row;
    for (std::size_t i = 0; i < std::min(names.size(), values.size()); ++i) row[names[i]] = values[i];
    rows.push_back(row);
  }
  return rows;
}

double real(const Row& row, const std::string& name) {
  const auto it = row.find(name);
  return it == row.end() ? 0.0 : base::parse_real(it->second).value_or(0.0);
}

double ground_at(double e, double n) {
  return 2.6 + 0.035 * e - 0.02 * n + 0.5 * std::sin(0.11 * e + 0.4) * std::cos(0.09 * n) +
         0.06 * std::sin(0.9 * e) * std::sin(0.8 * n);
}

// An ellipsoid with bumps, cut flat at the ground.
geometry::TriangleMesh lumpy(const Vec3& foot, double width, double height, std::uint64_t key) {
  base::Random random(7, "lumpy", key);
  constexpr std::size_t kRings = 22, kSectors = 36;
  geometry::TriangleMesh mesh;
  const double phase1 = random.uniform(0, 6.28), phase2 = random.uniform(0, 6.28), lean = random.uniform(-0.14, 0.14);
  mesh.vertices.push_back(foot);
  for (std::size_t r = 0; r < kRings; ++r) {
    const double t = static_cast<double>(r) / static_cast<double>(kRings);
    const double profile = 0.62 + 0.38 * std::sin(std::numbers::pi * std::pow(t, 0.8));
    const double cap = std::sqrt(std::max(0.02, 1.0 - std::pow(t, 4.0)));
    for (std::size_t s = 0; s < kSectors; ++s) {
      const double a = 2.0 * std::numbers::pi * static_cast<double>(s) / static_cast<double>(kSectors);
      const double bump = 1.0 + 0.12 * std::sin(2 * a + phase1) + 0.06 * std::sin(5 * a + phase2 + 6 * t) +
                          0.03 * std::sin(9 * a + 11 * t);
      const double radius = 0.5 * width * profile * cap * bump;
      mesh.vertices.push_back(foot +
                              Vec3(radius * 1.2 * std::cos(a) + lean * t * width, radius * std::sin(a), t * height));
    }
  }
  mesh.vertices.push_back(foot + Vec3(lean * width, 0.0, height));
  const auto at = [](std::size_t r, std::size_t s) {
    return static_cast<std::uint32_t>(1 + r * kSectors + s % kSectors);
  };
  for (std::size_t s = 0; s < kSectors; ++s) {
    mesh.triangles.push_back({0, at(0, s + 1), at(0, s)});
    for (std::size_t r = 0; r + 1 < kRings; ++r) {
      mesh.triangles.push_back({at(r, s), at(r, s + 1), at(r + 1, s + 1)});
      mesh.triangles.push_back({at(r, s), at(r + 1, s + 1), at(r + 1, s)});
    }
    mesh.triangles.push_back(
        {at(kRings - 1, s), at(kRings - 1, s + 1), static_cast<std::uint32_t>(mesh.vertices.size() - 1)});
  }
  for (const Vec3& v : mesh.vertices) {
    const double tone = 0.75 + 0.25 * std::sin(40 * v.x()) * std::sin(31 * v.y() + 17 * v.z());
    mesh.colours.push_back({static_cast<std::uint8_t>(168 * tone), static_cast<std::uint8_t>(150 * tone),
                            static_cast<std::uint8_t>(128 * tone)});
  }
  return mesh;
}

// Level contact: a_qs/g toward u is the least d_e / (H u.n_e) over the edges that u leaves by.
void fill_tipping(survey::Tipping& tipping, const std::vector<Vec3>& contact, const Vec3& com) {
  tipping.a_qs_g_by_azimuth.assign(360, std::numeric_limits<double>::infinity());
  survey::TippingEdge best;
  best.alpha_rad = 10.0;
  for (std::size_t i = 0; i < contact.size(); ++i) {
    const Vec2 a = contact[i].head<2>(), b = contact[(i + 1) % contact.size()].head<2>();
    const Vec2 along = (b - a).normalized(), normal(along.y(), -along.x());
    const double d = (a - com.head<2>()).dot(normal), rise = com.z() - contact[i].z();
    const double alpha = std::atan2(d, rise);
    if (alpha < best.alpha_rad) {
      best = {base::azimuth_deg(normal.x(), normal.y()), alpha, std::hypot(d, rise), 0, d / rise, 0};
      best.p_rad_s = std::sqrt(0.75 * 9.80665 / best.r_m);
      best.v_min_m_s = 2.0 * 9.80665 / best.p_rad_s * std::sin(alpha / 2) / std::cos(alpha);
    }
    for (std::size_t az = 0; az < 360; ++az) {
      const double t = base::deg_to_rad(static_cast<double>(az));
      const double cosine = Vec2(std::sin(t), std::cos(t)).dot(normal);
      if (cosine > 1e-6) tipping.a_qs_g_by_azimuth[az] = std::min(tipping.a_qs_g_by_azimuth[az], d / rise / cosine);
    }
  }
  tipping.critical = best;
}

report::CoverageView sample_coverage() {
  report::CoverageView c;
  c.facets = 184220;
  c.area_m2 = 8412.4;
  c.complete_fraction = 0.713;
  c.interval_95 = {0.664, 0.757};
  c.gates = {{"views", "at least 3", 0.902},
             {"gsd", "at most 20 mm/px", 0.988},
             {"incidence", "at most 60°", 0.931},
             {"parallax", "at least 10°", 0.774}};
  c.verdicts = {{"passed", 5998.0},     {"no_data", 310.2},  {"out_of_frame", 640.1}, {"occluded", 122.9},
                {"too_oblique", 580.0}, {"too_coarse", 0.0}, {"low_parallax", 761.2}};
  report::Histogram views{"views", "Views of a facet", "", {}, {}, 3.0, true};
  for (int i = 0; i <= 13; ++i) views.edges.push_back(i);
  views.areas_m2 = {120, 250, 455, 700, 980, 1260, 1430, 1120, 840, 560, 400, 200, 97};
  report::Histogram gsd{"gsd_mm_px",
                        "Best ground sampling distance",
                        "mm/px",
                        {15, 15.5, 16, 16.5, 17, 17.5, 18, 18.5, 19, 19.5, 20, 20.5, 21},
                        {40, 220, 700, 1500, 2200, 1800, 1000, 500, 250, 100, 60, 42},
                        20.0,
                        false};
  report::Histogram incidence{"incidence_deg", "Best incidence", "°", {}, {}, 60.0, false};
  report::Histogram parallax{"parallax_deg", "Greatest parallax", "°", {}, {}, 10.0, true};
  for (int i = 0; i <= 18; ++i) incidence.edges.push_back(5 * i);
  for (int i = 0; i < 18; ++i) incidence.areas_m2.push_back(1700 * std::exp(-0.28 * i) + 30);
  for (int i = 0; i <= 14; ++i) parallax.edges.push_back(5 * i);
  for (int i = 0; i < 14; ++i) parallax.areas_m2.push_back(300 + 900 * std::exp(-0.12 * (i - 6) * (i - 6)));
  c.histograms = {views, gsd, incidence, parallax};
  base::Random random(3, "gaps", 0);
  const char* kReasons[] = {"out_of_frame", "low_parallax", "too_oblique", "occluded"};
  for (int i = 1; i <= 14; ++i) {
    report::GapView g;
    g.id = i;
    g.centroid = {random.uniform(-45, 42), random.uniform(-30, 38)};
    const double size = random.uniform(0.6, 4.5);
    geometry::Ring ring;
    for (int k = 0; k < 14; ++k) {
      const double a = 2 * std::numbers::pi * k / 14;
      const double r = size * random.uniform(0.7, 1.2);
      ring.push_back(g.centroid + Vec2(r * std::cos(a), r * std::sin(a)));
    }
    g.rings = {ring};
    g.area_m2 = geometry::signed_area(ring);
    g.reasons = {kReasons[i % 4]};
    if (i % 5 == 0) g.reasons.emplace_back("too_coarse");
    g.nearest_frames = {"DJI_0020.JPG", "DJI_0021.JPG"};
    if (i % 3 == 0) g.suggestion = "One view from 12 m to the south, 30 m up, camera 40° down.";
    c.gaps.push_back(g);
  }
  return c;
}

void add_rasters(report::ReportData& data) {
  const geometry::GridGeometry fine = geometry::covering_grid({-48, -36}, {46, 44}, 0.15);
  report::RasterView surface{report::RasterRole::surface, geometry::Grid<float>(fine, 0.0F), "m"};
  report::RasterView views{report::RasterRole::views, geometry::Grid<float>(fine, 0.0F), "views"};
  report::RasterView cost{report::RasterRole::costmap, geometry::Grid<float>(fine, 0.0F), "cost"};
  for (std::size_t r = 0; r < fine.rows; ++r) {
    for (std::size_t c = 0; c < fine.columns; ++c) {
      const Vec2 p = fine.centre(r, c);
      const bool outside = Vec2(p.x() + 1, p.y() - 4).cwiseProduct(Vec2(1.0 / 47, 1.0 / 39)).norm() > 1.05;
      double z = ground_at(p.x(), p.y()), nearest = 1e9;
      for (const report::TargetView& t : data.targets) {
        const double d = (t.target.centre.head<2>() - p).norm();
        nearest = std::min(nearest, d - 0.4);
        if (d < 1.0) z += 0.4 * std::exp(-8.0 * d * d);
      }
      const float nan = std::numeric_limits<float>::quiet_NaN();
      surface.grid.at(r, c) = outside ? nan : static_cast<float>(158.0 + z);
      const double seen = 7.5 - 0.09 * std::abs(p.x() - p.y()) - 0.04 * std::abs(p.x() + p.y()) + std::sin(0.2 * p.x());
      views.grid.at(r, c) = outside ? nan : static_cast<float>(std::max(0.0, std::round(seen)));
      cost.grid.at(r, c) =
          outside ? nan : static_cast<float>(nearest <= 0 ? 254.0 : std::floor(252.0 * std::exp(-1.1 * nearest)));
    }
  }
  data.rasters = {surface, views, cost};
}

}  // namespace

report::RockView sample_rock(std::int64_t id, const Vec3& foot, double width, double height, survey::Grade grade) {
  report::RockView view;
  survey::Rock& rock = view.rock;
  rock.target = survey::TargetId(id);
  rock.object_class = "boulder";
  view.mesh = lumpy(foot, width, height, static_cast<std::uint64_t>(id));
  for (std::size_t t = 0; t < view.mesh->triangles.size(); ++t)
    view.facet_seen.push_back(view.mesh->centroid(t).z() - foot.z() > 0.35 * height ? 1 : 0);
  rock.mass = geometry::mass_properties(*view.mesh);
  rock.cap = survey::CapModel::plane;
  rock.hull_volume_m3 = rock.mass->volume * 1.18;
  rock.density_kg_m3 = 2600.0;
  rock.point_count = static_cast<std::size_t>(90 * width * height * 3);
  rock.point_spacing_m = 0.09;
  rock.size_m = {width * 1.2, width, height};
  rock.base_height_m = foot.z();
  rock.length_azimuth_deg = 90.0;
  rock.unseen_area_fraction = grade == survey::Grade::measured ? 0.08 : 0.42;
  rock.tipping.grade = grade;
  rock.tipping.contact_assumed = grade == survey::Grade::screening || grade == survey::Grade::not_measurable;
  std::vector<Vec2> base;
  for (std::size_t i = 1; i <= 36; i += 3) base.push_back(view.mesh->vertices[i].head<2>());
  for (const Vec2& q : geometry::convex_hull(base)) rock.tipping.contact.emplace_back(q.x(), q.y(), foot.z());
  switch (grade) {
    case survey::Grade::measured: break;
    case survey::Grade::bounded: rock.tipping.reasons = {"contact_partly_seen", "partly_unseen"}; break;
    case survey::Grade::screening: rock.tipping.reasons = {"contact_assumed", "partly_unseen"}; break;
    case survey::Grade::not_measurable:
      rock.tipping.reasons = {"too_coarse", "sides_not_seen", "contact_assumed"};
      break;
  }
  if (grade != survey::Grade::not_measurable)
    fill_tipping(rock.tipping, rock.tipping.contact, rock.mass->centre_of_mass);
  view.model_file = "rocks/" + std::to_string(id) + ".glb";
  return view;
}

report::ReportData tiny_report() {
  report::ReportData data;
  data.manifest.name = "tiny";
  data.manifest.origin = {{46.8426, -91.994, 158.0}, survey::HeightType::unknown, ""};
  survey::Target target;
  target.id = survey::TargetId(1);
  target.object_class = "boulder";
  target.state = survey::TargetState::converged;
  target.centre = {10.0, 5.0, 2.0};
  target.covariance = 1e-4 * geometry::Mat3::Identity();
  data.targets.push_back({target, {}});
  data.provenance.version = "0.1.0";
  return data;
}

report::ReportData hostile_report() {
  const std::string mark = "\"'><img src=x onerror=\"document.documentElement.dataset.broken='yes'\">";
  const std::string script = "</script></title></style><script>document.documentElement.dataset.broken='yes'</script>";
  const std::string url = "javascript:document.documentElement.dataset.broken='yes'";
  report::ReportData data = tiny_report();
  data.manifest.name = "name" + script + mark;
  data.manifest.notes = {mark, script, "line\xE2\x80\xA8separator", "bad utf-8 \xC3\x28 \xFF",
                         std::string("nul\0byte", 8)};
  data.manifest.origin.geoid = mark;
  data.manifest.sources = {{mark, script, url, survey::Confidence::assumed, mark, survey::HeightType::unknown, {}}};
  data.targets[0].target.object_class = mark + script;
  data.targets[0].target.reasons = {mark, script};
  data.targets[0].photos = {{mark, "image/png\" onload=\"x", "abc"}, {script, "image/jpeg", "\xFF\xD8"}};
  report::RockView rock = sample_rock(1, {10.0, 5.0, 1.5}, 1.0, 1.2, survey::Grade::screening);
  rock.rock.object_class = mark;
  rock.rock.tipping.reasons = {script, mark};
  rock.model_file = url + mark;
  data.rocks.push_back(rock);
  report::FrameView frame;
  frame.frame.id = survey::FrameId(1);
  frame.frame.image = mark + script;
  frame.footprint = {{0, 0}, {20, 0}, {20, 20}, {0, 20}};
  data.frames.push_back(frame);
  survey::Obstacle obstacle;
  obstacle.target = survey::TargetId(1);
  obstacle.object_class = script;
  obstacle.position = {10.0, 5.0, 2.0};
  data.obstacles.push_back(obstacle);
  data.coverage = sample_coverage();
  data.coverage->gates[0].name = mark;
  data.coverage->verdicts[2].verdict = script + mark;
  data.coverage->gates[0].rule = script;
  data.coverage->histograms[0].title = mark;
  data.coverage->histograms[0].unit = script;
  data.coverage->gaps[0].reasons = {mark, script};
  data.coverage->gaps[0].nearest_frames = {script};
  data.coverage->gaps[0].suggestion = mark;
  data.route = report::RouteView{{{0, 0}, {9, 9}}, 12.7, {}, {}, mark + script};
  data.rejects = {{mark, {script, mark, script + mark}}};
  data.provenance.version = mark;
  data.provenance.recipe = script;
  data.provenance.warnings = {mark, script};
  data.provenance.inputs = {{mark, script}};
  data.provenance.crs_operations = {script};
  data.provenance.options = io::Json::object({{mark, script}});
  return data;
}

report::ReportData sample_report(const std::filesystem::path& folder) {
  report::ReportData data = tiny_report();
  data.targets.clear();
  data.manifest.name = "Brighton Beach";
  data.manifest.origin.height_type = survey::HeightType::unknown;
  data.manifest.notes = {"The cloud lies 0.57 m east and 0.92 m above the poses; its similarity is applied.",
                         "Heights are those of the EXIF GPSAltitude tag; no vertical datum is declared."};
  survey::Camera camera;
  camera.id = survey::CameraId(1);
  camera.name = "FC300S";
  camera.width_px = 4000;
  camera.height_px = 2250;
  camera.fx_px = camera.fy_px = 2285.714;
  camera.cx_px = 2000;
  camera.cy_px = 1125;
  data.manifest.cameras = {camera};
  data.manifest.sources = {{"poses",
                            "colmap_enu",
                            "COLMAP world-to-camera quaternions, inverted; corner pixels",
                            survey::Confidence::declared,
                            "local",
                            survey::HeightType::ellipsoidal,
                            {}},
                           {"cloud",
                            "model.las",
                            "UTM zone 15N, metres, converted point by point",
                            survey::Confidence::inferred,
                            "EPSG:32615",
                            survey::HeightType::unknown,
                            {}}};
  for (const Row& row : read_table(folder / "frames.csv")) {
    report::FrameView f;
    f.frame.id = survey::FrameId(*base::parse_integer(row.at("frame_id")));
    f.frame.time_ns = *base::parse_integer(row.at("time_ns"));
    f.frame.camera = camera.id;
    f.frame.image = row.at("image");
    f.frame.T_world_camera.rotation =
        geometry::rotation_matrix({real(row, "qw"), real(row, "qx"), real(row, "qy"), real(row, "qz")});
    f.frame.T_world_camera.translation = {real(row, "x_m"), real(row, "y_m"), real(row, "z_m")};
    f.footprint = camera::footprint(camera, f.frame.T_world_camera, 3.0);
    data.frames.push_back(f);
  }
  data.detections = 314;

  using survey::Grade;
  base::Random random(11, "sample", 0);
  std::int64_t id = 0;
  for (const Row& row : read_table(folder / "objects.csv")) {
    survey::Target t;
    t.id = survey::TargetId(++id);
    t.object_class = row.at("class");
    t.state = id % 9 == 0 ? survey::TargetState::converged : survey::TargetState::mapped;
    t.centre = {real(row, "east_m"), real(row, "north_m"), real(row, "up_m")};
    t.covariance.diagonal() =
        Vec3(real(row, "sigma_east_m"), real(row, "sigma_north_m"), real(row, "sigma_up_m")).cwiseAbs2();
    for (std::int64_t k = 0; k < static_cast<std::int64_t>(real(row, "n_labels")); ++k) {
      t.detections.emplace_back(id * 10 + k);
      t.keyframes.emplace_back(18 + k);
      t.entropy_nats.push_back(-1.0 - 1.4 * std::log1p(static_cast<double>(k)) + random.uniform(-0.1, 0.1));
    }
    t.mean_score = random.uniform(0.7, 0.95);
    const double width = std::max(0.3, 0.5 * (real(row, "box_width_m") + real(row, "box_height_m")));
    const double height = t.object_class == "tree"  ? 3.4
                          : t.object_class == "car" ? 1.5
                                                    : width * random.uniform(0.6, 1.5);
    const double bottom = ground_at(t.centre.x(), t.centre.y());
    t.bcylinder = geometry::VerticalCylinder{t.centre.head<2>(), bottom, bottom + height, 0.6 * width};
    data.targets.push_back({t, {}});
    survey::Obstacle o;
    o.target = t.id;
    o.object_class = t.object_class;
    o.kind = t.object_class == "tree" ? survey::ObstacleKind::ignored : survey::ObstacleKind::obstacle;
    o.position = {t.centre.x(), t.centre.y(), bottom};
    o.covariance = t.covariance.topLeftCorner<2, 2>();
    o.width_m = width;
    o.height_m = height;
    o.score = t.mean_score;
    o.observations = t.detections.size();
    data.obstacles.push_back(o);
    if (t.object_class != "boulder") continue;
    const Grade grade = id % 11 == 3 ? Grade::bounded : id % 3 == 0 ? Grade::screening : Grade::not_measurable;
    report::RockView rock =
        sample_rock(id, {t.centre.x(), t.centre.y(), bottom}, width, height, id == 2 ? Grade::measured : grade);
    if (id % 8 == 5) {
      rock = {};
      rock.rock.target = t.id;
      rock.rock.object_class = t.object_class;
      rock.rock.rejected = true;
      rock.rock.reasons = {"too_few_points"};
      data.rejects.push_back(
          {"rocks",
           {"target " + std::to_string(id), "too_few_points", "12 points of the cloud lie on it; 35 are needed"}});
    }
    data.rocks.push_back(rock);
  }
  data.targets.back().target.state = survey::TargetState::deregistered;
  data.targets.back().target.reasons = {"too_few_detections"};
  data.rejects.push_back({"locate", {"detection 311", "unassociated", "no other box points to the same place"}});
  data.coverage = sample_coverage();
  add_rasters(data);
  report::RouteView route;
  for (int i = 0; i <= 60; ++i) {
    const double t = i / 60.0;
    route.path.emplace_back(-38 + 74 * t, -14 + 30 * t + 4 * std::sin(7 * t));
    if (i > 0) route.length_m += (route.path[route.path.size() - 1] - route.path[route.path.size() - 2]).norm();
  }
  route.min_clearance_m = 0.82;
  route.planner = "A*, 8-connected, no corner cutting";
  data.route = route;
  data.provenance.recipe = "post_flight";
  data.provenance.options =
      io::Json::object({{"locate", io::Json::object({{"min-detections", 3}, {"gate-m", 1.5}})},
                        {"rocks", io::Json::object({{"min-points", 35}, {"density-kg-m3", 2600.0}})}});
  data.provenance.inputs = {{"survey.json", std::string(64, 'a')},
                            {"detections.csv", std::string(64, 'b')},
                            {"model.las", std::string(64, 'c')}};
  data.provenance.crs_operations = {"Inverse of UTM zone 15N + local east-north-up"};
  data.provenance.warnings = {"The survey declares no vertical datum: heights cannot be compared with other surveys."};
  return data;
}

}  // namespace cairn::testing
