#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "geodesy/local_frame.hpp"
#include "io/mission_json.hpp"
#include "io/mission_layers.hpp"
#include "io/qgc_plan.hpp"
#include "io/survey_folder.hpp"
#include "support/data.hpp"

namespace {

using cairn::geometry::Vec3;
using cairn::io::Json;
using cairn::survey::HeightType;
using cairn::survey::Mission;
using ::testing::HasSubstr;

Mission mission(HeightType type = HeightType::relative_takeoff) {
  Mission m;
  m.name = "test";
  m.kind = cairn::survey::MissionKind::cylinder;
  m.origin = {{48.21, 16.41, 200.0}, type, type == HeightType::orthometric ? "egm96" : ""};
  m.camera.id = cairn::survey::CameraId(1);
  m.camera.width_px = 640;
  m.camera.height_px = 480;
  m.camera.fx_px = m.camera.fy_px = 381.36;
  m.camera.cx_px = 320;
  m.camera.cy_px = 240;
  m.limits = {1.0, 1.0, 45.0};
  for (int i = 0; i < 3; ++i) {
    cairn::survey::Waypoint w;
    w.position = Vec3(0.1 * i, 1.0 / 3.0, 10.0 + i);
    w.heading_deg = 350.0 + 20.0 * i;
    w.pitch_deg = -60.0;
    w.stop = i != 1;
    w.photo = i < 2;
    w.trigger_m = i == 2 ? 0.0 : 0.5;
    w.role = cairn::survey::WaypointRole::circle;
    w.group = i;
    w.time_s = 1.5 * i;
    m.waypoints.push_back(w);
  }
  cairn::survey::Frame view;
  view.id = cairn::survey::FrameId(0);
  view.camera = m.camera.id;
  view.time_ns = 1'500'000'000;
  view.T_world_camera.rotation << 1, 0, 0, 0, -1, 0, 0, 0, -1;
  view.T_world_camera.translation = m.waypoints[1].position;
  m.views = {view};
  cairn::survey::PolynomialSegment segment;
  segment.duration_s = 3.0;
  segment.coefficients[1][7] = 1.0 / 7.0;
  m.trajectory = {segment};
  m.notes = {"a note"};
  return m;
}

TEST(MissionJson, ReadsBackBitForBit) {
  const cairn::testing::TempFolder folder;
  cairn::io::write_mission(folder / "mission.json", mission());
  EXPECT_TRUE(cairn::io::is_mission_file(folder / "mission.json"));
  const Mission back = cairn::io::read_mission(folder / "mission.json");
  EXPECT_EQ(cairn::io::to_json(back).dump(), cairn::io::to_json(mission()).dump());
  EXPECT_EQ(back.waypoints[2].position, mission().waypoints[2].position);
  EXPECT_EQ(back.trajectory[0].coefficients, mission().trajectory[0].coefficients);
  EXPECT_EQ(back.camera, mission().camera);
  cairn::base::write_file(folder / "other.json", "{}");
  EXPECT_FALSE(cairn::io::is_mission_file(folder / "other.json"));
}

TEST(MissionJson, RefusesWhatIsNoMission) {
  const auto refusal = [](const std::function<void(Json&)>& change) -> std::string {
    Json json = cairn::io::to_json(mission());
    change(json);
    try {
      static_cast<void>(cairn::io::mission_from_json(json, "m.json"));
    } catch (const cairn::base::Error& error) {
      EXPECT_EQ(error.code(), cairn::base::ErrorCode::invalid_input);
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(refusal([](Json&) {}), "");
  EXPECT_THAT(refusal([](Json& j) { j.set("schema_version", 9); }), HasSubstr("schema version"));
  EXPECT_THAT(refusal([](Json& j) { j.set("kind", "spiral"); }), HasSubstr("spiral"));
  EXPECT_THAT(refusal([](Json& j) {
                j.set("trajectory", Json(Json::Array{Json::object({{"duration_s", 0.0}})}));
              }),
              HasSubstr("without duration"));
  EXPECT_THAT(refusal([](Json& j) {
                Json views = j.at("views");
                views.push(views.as_array()[0]);
                j.set("views", views);
              }),
              HasSubstr("ascend"));
  Mission broken = mission();
  broken.waypoints[0].position.x() = std::nan("");
  EXPECT_THROW(static_cast<void>(cairn::io::to_json(broken)), cairn::base::Error);
}

const Json* waypoint(const Json& plan, std::size_t n) {
  for (const Json& item : plan.at("mission").at("items").as_array())
    if (item.at("command").as_integer() == 16 && n-- == 0) return &item;
  return nullptr;
}

TEST(QgcPlan, HeightsFollowTheirDatum) {
  const cairn::geodesy::LocalFrame frame(mission().origin.position);
  const double height = frame.to_geodetic(mission().waypoints[1].position).height_m;
  const auto of = [&](HeightType type, std::optional<double> home) { return cairn::io::qgc_plan(mission(type), home); };
  const Json relative = of(HeightType::relative_takeoff, std::nullopt);
  EXPECT_EQ(waypoint(relative, 1)->at("frame").as_integer(), 3);
  EXPECT_NEAR(waypoint(relative, 1)->at("Altitude").as_real(), height, 1e-3);
  const Json sea = of(HeightType::orthometric, std::nullopt);
  EXPECT_EQ(waypoint(sea, 1)->at("frame").as_integer(), 0);
  EXPECT_NEAR(waypoint(sea, 1)->at("Altitude").as_real(), height, 1e-3);
  // EGM96 stands 44.71 m above the ellipsoid here.
  const Json ellipsoidal = of(HeightType::ellipsoidal, std::nullopt);
  EXPECT_NEAR(waypoint(ellipsoidal, 1)->at("Altitude").as_real(), height - 44.71, 0.1);
  const Json unknown = of(HeightType::unknown, 2.0);
  EXPECT_EQ(waypoint(unknown, 1)->at("frame").as_integer(), 3);
  EXPECT_NEAR(waypoint(unknown, 1)->at("Altitude").as_real(), 9.0, 1e-3);
  EXPECT_THROW(static_cast<void>(of(HeightType::unknown, std::nullopt)), cairn::base::Error);
  Mission none = mission();
  none.waypoints.clear();
  EXPECT_THROW(static_cast<void>(cairn::io::qgc_plan(none, std::nullopt)), cairn::base::Error);
}

TEST(QgcPlan, HasPositionsYawImagesAndTriggers) {
  const Json plan = cairn::io::qgc_plan(mission(), std::nullopt);
  const cairn::geodesy::LocalFrame frame(mission().origin.position);
  const auto g = frame.to_geodetic(mission().waypoints[1].position);
  const auto& params = waypoint(plan, 1)->at("params").as_array();
  ASSERT_EQ(params.size(), 7U);
  EXPECT_NEAR(params[3].as_real(), 10.0, 1e-9);  // 370 deg
  EXPECT_NEAR(params[4].as_real(), g.latitude_deg, 1e-9);
  EXPECT_NEAR(params[5].as_real(), g.longitude_deg, 1e-9);
  std::vector<std::int64_t> commands;
  for (const Json& item : plan.at("mission").at("items").as_array())
    commands.push_back(item.at("command").as_integer());
  EXPECT_THAT(commands, ::testing::ElementsAre(178, 205, 16, 206, 2000, 16, 2000, 16, 206));
}

TEST(MissionLayers, ShowPathWaypointsAndViews) {
  const auto points = cairn::io::waypoint_layer(mission());
  EXPECT_EQ(points.features.size(), 3U);
  EXPECT_NO_THROW(cairn::io::validate(points));
  EXPECT_NO_THROW(cairn::io::validate(cairn::io::path_layer(mission())));
  const auto views = cairn::io::view_layer(mission());
  EXPECT_NO_THROW(cairn::io::validate(views));
  ASSERT_EQ(views.features.size(), 1U);
  // Straight down, image top to the north.
  EXPECT_NEAR(std::get<double>(views.features[0].values[views.column("pitch_deg")]), -90.0, 1e-9);
  EXPECT_NEAR(std::get<double>(views.features[0].values[views.column("heading_deg")]), 0.0, 1e-9);
  const Json geojson = cairn::io::parse_json(cairn::io::mission_geojson(mission()), "geojson");
  EXPECT_EQ(geojson.at("features").size(), 5U);
}

}  // namespace
