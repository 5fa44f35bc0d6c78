// `cairn plan`: what a user gives and gets.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "base/atomic_file.hpp"
#include "geodesy/local_frame.hpp"
#include "io/csv.hpp"
#include "io/json.hpp"
#include "io/mission_json.hpp"
#include "io/raster.hpp"
#include "io/survey_folder.hpp"
#include "io/targets_json.hpp"
#include "planning/minimum_snap.hpp"
#include "support/data.hpp"
#include "support/run_program.hpp"
#include "support/small_survey.hpp"

namespace {

namespace fs = std::filesystem;
using cairn::geometry::Vec3;
using cairn::testing::cairn;
using cairn::testing::TempFolder;
using ::testing::HasSubstr;

const cairn::survey::Origin kOrigin{cairn::testing::kSmallSurveyOrigin, cairn::survey::HeightType::relative_takeoff,
                                    ""};

class PlanCommand : public ::testing::Test {
 protected:
  TempFolder folder_;
  [[nodiscard]] std::string path(const std::string& name) const { return (folder_ / name).string(); }

  // A rectangle of 60 x 40 m about the origin as GeoJSON, its corners in this order.
  [[nodiscard]] std::string area(const std::vector<int>& order = {0, 1, 2, 3}) const {
    const cairn::geodesy::LocalFrame frame(kOrigin.position);
    const Vec3 corners[] = {{-30, -20, 0}, {30, -20, 0}, {30, 20, 0}, {-30, 20, 0}};
    cairn::io::Json ring = cairn::io::Json::array();
    for (std::size_t i = 0; i <= order.size(); ++i) {
      const auto g = frame.to_geodetic(corners[order[i % order.size()]]);
      ring.push(cairn::io::Json(std::vector<double>{g.longitude_deg, g.latitude_deg}));
    }
    auto feature = cairn::io::Json::object(
        {{"type", "Feature"},
         {"properties", cairn::io::Json::object()},
         {"geometry", cairn::io::Json::object(
                          {{"type", "Polygon"}, {"coordinates", cairn::io::Json(cairn::io::Json::Array{ring})}})}});
    const auto file = cairn::io::Json::object(
        {{"type", "FeatureCollection"}, {"features", cairn::io::Json(cairn::io::Json::Array{feature})}});
    cairn::base::write_file(path("area.geojson"), file.dump());
    return path("area.geojson");
  }
  // Heights over 140 x 140 m: level at `ground`, with a boulder of 2 m at (10, 5).
  [[nodiscard]] std::string terrain(float ground = 0.0F) const {
    cairn::geometry::Grid<float> up({-70, 70, 0.5, 280, 280}, ground);
    for (std::size_t r = 0; r < 280; ++r)
      for (std::size_t c = 0; c < 280; ++c)
        if ((up.geometry.centre(r, c) - cairn::geometry::Vec2(10, 5)).norm() < 1.2) up.at(r, c) += 2.0F;
    // Heights in the datum of the origin.
    for (float& v : up.values) v += static_cast<float>(kOrigin.position.height_m);
    cairn::io::write_cog(path("dsm.tif"), {{"surface", "m", "", up, std::nullopt}},
                         cairn::geodesy::LocalFrame(kOrigin.position).raster_crs_wkt());
    return path("dsm.tif");
  }
  static cairn::survey::Target target(std::int64_t id, const Vec3& foot, double height, double radius) {
    cairn::survey::Target t;
    t.id = cairn::survey::TargetId(id);
    t.object_class = "boulder";
    t.state = cairn::survey::TargetState::converged;
    t.bcylinder = cairn::geometry::VerticalCylinder{foot.head<2>(), foot.z(), foot.z() + height, radius};
    t.centre = t.bcylinder->centre();
    return t;
  }
  [[nodiscard]] std::string targets(std::vector<cairn::survey::Target> list) const {
    cairn::io::write_targets(path("targets.json"), {kOrigin, std::move(list)});
    return path("targets.json");
  }
  [[nodiscard]] static cairn::testing::ProgramResult plan(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), "plan");
    return cairn(arguments);
  }
  void expect_sound_mission(const std::string& out) const;
};

// Whatever the kind: limits on 1 ms samples, a draft, no take-off, the same points in every file.
void PlanCommand::expect_sound_mission(const std::string& out) const {
  const auto mission = cairn::io::read_mission(fs::path(out) / "mission.json");
  ASSERT_FALSE(mission.waypoints.empty());
  double speed = 0.0, acceleration = 0.0;
  for (const auto& s : mission.trajectory)
    for (double t = 0.0; t < s.duration_s; t += 0.001) {
      speed = std::max(speed, cairn::planning::evaluate(s, t, 1).head<3>().norm());
      acceleration = std::max(acceleration, cairn::planning::evaluate(s, t, 2).head<3>().norm());
    }
  EXPECT_LE(speed, mission.limits.max_speed_m_s);
  EXPECT_LE(acceleration, mission.limits.max_acceleration_m_s2);
  EXPECT_GT(speed, 0.5 * mission.limits.max_speed_m_s);
  for (const auto& view : mission.views) {
    const double t = 1e-9 * static_cast<double>(view.time_ns);
    EXPECT_LT((cairn::planning::evaluate(mission.trajectory, t).head<3>() - view.T_world_camera.translation).norm(),
              0.05);
  }

  const auto file = cairn::io::read_json(fs::path(out) / "mission.plan");
  EXPECT_EQ(file.at("fileType").as_string(), "Plan");
  EXPECT_THAT(file.at("groundStation").as_string(), HasSubstr("DRAFT"));
  EXPECT_EQ(file.at("cairn").at("status").as_string(), "DRAFT");
  std::size_t points = 0;
  std::int64_t id = 0;
  const std::set<std::int64_t> never{20, 21, 22, 23, 24, 84, 85};  // return, land, take off
  for (const auto& item : file.at("mission").at("items").as_array()) {
    EXPECT_EQ(item.at("type").as_string(), "SimpleItem");
    EXPECT_EQ(item.at("doJumpId").as_integer(), ++id);
    EXPECT_EQ(item.at("params").size(), 7U);
    EXPECT_EQ(never.count(item.at("command").as_integer()), 0U);
    points += item.at("command").as_integer() == 16 ? 1 : 0;
  }
  EXPECT_EQ(points, mission.waypoints.size());
  cairn::io::CsvReader csv(fs::path(out) / "mission.csv");
  std::size_t rows = 0;
  while (csv.next()) ++rows;
  EXPECT_EQ(rows, mission.waypoints.size());
  const auto geojson = cairn::io::read_json(fs::path(out) / "mission.geojson");
  EXPECT_THAT(geojson.at("name").as_string(), HasSubstr("DRAFT"));
  EXPECT_EQ(geojson.at("features").size(), 1 + mission.waypoints.size() + mission.views.size());
  EXPECT_THAT(cairn::base::read_file(fs::path(out) / "mission.kml"), HasSubstr("DRAFT"));
  EXPECT_TRUE(fs::exists(fs::path(out) / "run.json"));
}

TEST_F(PlanCommand, LawnmowerAsInTheManual) {
  const auto result = plan({"lawnmower", "--area", area(), "--gsd", "0.01", "--overlap", "0.8,0.7", "--terrain",
                            terrain(), "-o", path("plan"), "--json"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto s = cairn::io::parse_json(result.out, "stdout");
  EXPECT_EQ(s.at("overlap").at("uncovered").as_integer(), 0);
  EXPECT_GE(s.at("overlap").at("first_percentile_views").as_integer(), s.at("wanted_views").as_integer());
  EXPECT_EQ(s.at("wanted_views").as_integer(), 15);
  EXPECT_NEAR(s.at("height_m").as_real(), 36.85, 1e-9);
  EXPECT_GE(s.at("least_clearance_m").as_real(), 34.6);
  EXPECT_LE(s.at("least_clearance_m").as_real(), 36.9);
  expect_sound_mission(path("plan"));
  // The same bytes on any number of threads.
  ASSERT_EQ(plan({"lawnmower", "--area", area(), "--gsd", "0.01", "--overlap", "0.8,0.7", "--terrain", path("dsm.tif"),
                  "-o", path("again"), "--threads", "1"})
                .exit_code,
            0);
  for (const char* name : {"mission.json", "mission.plan", "mission.kml", "mission.csv", "mission.geojson"})
    EXPECT_EQ(cairn::base::read_file(fs::path(path("plan")) / name),
              cairn::base::read_file(fs::path(path("again")) / name));
}

TEST_F(PlanCommand, LawnmowerNeedsNothingButAnArea) {
  const auto result = plan({"lawnmower", "--area", area(), "--height-m", "25", "--cross-hatch", "--gimbal-pitch-deg",
                            "-60", "--max-speed-m-s", "4", "--budget", "1min", "-o", path("plan"), "--json"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.err, HasSubstr("camera assumed"));
  EXPECT_THAT(result.err, HasSubstr("longer than the budget"));
  const auto s = cairn::io::parse_json(result.out, "stdout");
  EXPECT_FALSE(s.at("within_budget").as_bool());
  EXPECT_EQ(s.at("overlap").at("uncovered").as_integer(), 0);
  expect_sound_mission(path("plan"));
}

TEST_F(PlanCommand, CirclesSeeTheWholeCylinder) {
  const auto result = plan(
      {"cylinder", "--targets",
       targets({target(3, {0, 0, 0}, 1.8, 0.7), target(7, {25, 8, 0.5}, 9.0, 1.5), target(9, {5, 5, 0}, 0.0, 1.0)}),
       "--terrain", terrain(), "-o", path("plan"), "--json"});
  ASSERT_EQ(result.exit_code, 3) << result.err;  // target 9 has no height
  EXPECT_THAT(result.err, HasSubstr("target 9"));
  const auto s = cairn::io::parse_json(result.out, "stdout");
  EXPECT_EQ(s.at("targets").as_integer(), 2);
  EXPECT_EQ(s.at("rejects").at("cylinder_without_height").as_integer(), 1);
  EXPECT_GE(s.at("least_side_seen").as_real(), 0.99);
  EXPECT_GE(s.at("least_top_seen").as_real(), 0.99);
  EXPECT_GE(s.at("least_clearance_m").as_real(), 2.9);
  expect_sound_mission(path("plan"));
  const auto mission = cairn::io::read_mission(fs::path(path("plan")) / "mission.json");
  std::int64_t circles = 0;
  for (std::size_t i = 1; i < mission.waypoints.size(); ++i) {
    const auto &a = mission.waypoints[i - 1], &b = mission.waypoints[i];
    if (a.role == b.role && a.role == cairn::survey::WaypointRole::circle && a.group == b.group) {
      EXPECT_GT(b.heading_deg, a.heading_deg);  // never unwinds
    }
    circles = std::max(circles, b.group + 1);
  }
  EXPECT_GE(circles, 3);
}

// A nadir flight misses the walls; the re-flight sees them, and its own coverage says the same.
TEST_F(PlanCommand, ReFlightClosesTheWallsOfABoulder) {
  auto survey = cairn::testing::small_survey(7);
  survey.manifest.origin = kOrigin;
  for (auto& frame : survey.frames) frame.T_world_camera.translation.y() = 5.0;
  fs::create_directory(path("survey"));
  cairn::io::write_survey(survey, path("survey"));
  const auto list = targets({target(1, {10, 5, 0}, 2.0, 1.2)});
  const auto covered = cairn({"coverage", "--surface", terrain(), "--views", path("survey"), "--targets", list,
                              "--target-gsd-of-height", "0.01", "-o", path("coverage"), "--json"});
  ASSERT_EQ(covered.exit_code, 0) << covered.err;
  const auto result = plan({"gaps", path("coverage"), "--budget", "15min", "-o", path("plan"), "--json"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto s = cairn::io::parse_json(result.out, "stdout");
  EXPECT_LT(s.at("least_wall_before").as_real(), 0.5);
  EXPECT_GE(s.at("least_wall_after").as_real(), 0.95);
  EXPECT_GE(s.at("least_top_after").as_real(), 0.95);
  EXPECT_TRUE(s.at("within_budget").as_bool());
  EXPECT_GE(s.at("least_clearance_m").as_real(), 2.9);
  expect_sound_mission(path("plan"));
  EXPECT_TRUE(fs::exists(fs::path(path("plan")) / "coverage.json"));

  // The planned mission as views of its own: the recorded ones were the third views, none of them steep enough.
  const auto alone = cairn({"coverage", "--surface", path("dsm.tif"), "--views", path("plan"), "--targets", list,
                            "--min-views", "2", "-o", path("alone"), "--json"});
  ASSERT_EQ(alone.exit_code, 0) << alone.err;
  const auto rows = cairn::io::read_json(fs::path(path("alone")) / "targets_coverage.json");
  EXPECT_GT(rows.at("targets").as_array().at(0).at("wall").at("completeness").as_real(), 0.9);

  // A budget for a few views only: as many as fit, and it says so.
  const auto brief = plan({"gaps", path("coverage"), "--budget", "30s", "-o", path("brief"), "--json"});
  ASSERT_EQ(brief.exit_code, 0) << brief.err;
  EXPECT_THAT(brief.err, HasSubstr("the budget allows"));
  const auto b = cairn::io::parse_json(brief.out, "stdout");
  EXPECT_LT(b.at("images").as_integer(), s.at("images").as_integer());
  EXPECT_LE(b.at("duration_s").as_real(), 30.0);
}

TEST_F(PlanCommand, BadInputIsNamed) {
  const auto crossing = plan({"lawnmower", "--area", area({0, 2, 1, 3}), "--gsd", "0.01", "-o", path("plan")});
  EXPECT_EQ(crossing.exit_code, 4);
  EXPECT_THAT(crossing.err, HasSubstr("crosses or touches itself"));
  EXPECT_THAT(crossing.err, HasSubstr("area.geojson"));

  const auto flat = plan({"cylinder", "--targets", targets({target(1, {0, 0, 0}, 0.0, 1.0)}), "-o", path("plan")});
  EXPECT_EQ(flat.exit_code, 4);
  EXPECT_THAT(flat.err, HasSubstr("no target can be circled"));
  EXPECT_THAT(flat.err, HasSubstr("both must be above 0"));

  // 40 m below the terrain: the circles would lie in the ground.
  const auto below = plan({"cylinder", "--targets", targets({target(1, {0, 0, -40}, 2.0, 1.0)}), "--terrain", terrain(),
                           "-o", path("plan")});
  EXPECT_EQ(below.exit_code, 4);
  EXPECT_THAT(below.err, HasSubstr("--clearance-m"));

  const auto neither = plan({"lawnmower", "--area", area(), "-o", path("plan")});
  EXPECT_EQ(neither.exit_code, 2);
  EXPECT_THAT(neither.err, HasSubstr("neither"));
  EXPECT_EQ(plan({"lawnmower", "--gsd", "0.01", "-o", path("plan")}).exit_code, 2);
  EXPECT_EQ(plan({"gaps", path("nowhere"), "-o", path("plan")}).exit_code, 4);
  fs::create_directory(path("empty"));
  const auto empty = plan({"gaps", path("empty"), "-o", path("plan")});
  EXPECT_EQ(empty.exit_code, 4);
  EXPECT_THAT(empty.err, HasSubstr("no result of 'cairn coverage'"));
  const auto budget = plan({"lawnmower", "--area", area(), "--gsd", "0.01", "--budget", "soon", "-o", path("plan")});
  EXPECT_EQ(budget.exit_code, 2);
  EXPECT_THAT(budget.err, HasSubstr("15min"));
  EXPECT_FALSE(fs::exists(path("plan")));
}

}  // namespace
