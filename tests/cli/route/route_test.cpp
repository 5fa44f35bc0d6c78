#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <fstream>

#include "base/number_text.hpp"
#include "io/json.hpp"
#include "io/packets.hpp"
#include "io/vehicle_csv.hpp"
#include "support/data.hpp"
#include "support/run_program.hpp"
#include "support/small_ground.hpp"

namespace {

namespace fs = std::filesystem;
using cairn::testing::cairn;
using cairn::testing::TempFolder;
using ::testing::HasSubstr;

class RouteCommand : public ::testing::Test {
 protected:
  TempFolder folder_;
  std::string cost_ = (folder_ / "cost/costmap.tif").string(), out_ = (folder_ / "route").string();
  void SetUp() override {
    cairn::testing::write_small_ground(folder_.path());
    ASSERT_EQ(cairn({"costmap", "--obstacles", (folder_ / "obstacles.json").string(), "--surface",
                     (folder_ / "surface.tif").string(), "-o", (folder_ / "cost").string()})
                  .exit_code,
              0);
  }
  [[nodiscard]] cairn::testing::ProgramResult run(std::vector<std::string> more) const {
    std::vector<std::string> arguments{"route", cost_, "-o", out_, "--json", "--overwrite"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return cairn(arguments);
  }
};

TEST_F(RouteCommand, GoesRoundTheBoulder) {
  const auto result = run({"--from-local", "3,4", "--to-local", "7,4"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto summary = cairn::io::parse_json(result.out, "stdout");
  EXPECT_GT(summary.at("length_m").as_real(), 4.0);
  EXPECT_LT(summary.at("length_m").as_real(), 6.5);
  EXPECT_GT(summary.at("clearance_m").as_real(), 0.35);
  EXPECT_TRUE(fs::exists(fs::path(out_) / "route.geojson"));
  EXPECT_TRUE(fs::exists(fs::path(out_) / "run.json"));
}

TEST_F(RouteCommand, GeographicEndsAreTheSamePlaces) {
  const cairn::geodesy::LocalFrame frame(cairn::testing::kSmallGroundOrigin);
  const auto text = [&](double e, double n) {
    const auto g = frame.to_geodetic({e, n, 0.0});
    return cairn::base::to_fixed(g.latitude_deg, 9) + "," + cairn::base::to_fixed(g.longitude_deg, 9);
  };
  const auto local = run({"--from-local", "3.01,4.01", "--to-local", "7.01,4.01"});
  const auto geographic = run({"--from", text(3.01, 4.01), "--to", text(7.01, 4.01)});
  ASSERT_EQ(geographic.exit_code, 0) << geographic.err;
  EXPECT_EQ(local.out, geographic.out);
}

TEST_F(RouteCommand, ChoosesEndsAndSaysSo) {
  const auto result = run({});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("chosen: far apart"));
}

TEST_F(RouteCommand, SaysWhyThereIsNoRoute) {
  const std::pair<std::vector<std::string>, std::pair<int, const char*>> cases[] = {
      {{"--from-local", "5,4", "--to-local", "7,4"}, {4, "start_blocked"}},
      {{"--from-local", "3,4", "--to-local", "9,7"}, {4, "goal_blocked"}},
      {{"--from-local", "3,4", "--to-local", "70,4"}, {4, "outside the costmap"}},
      {{"--from-local", "3,4"}, {2, "both ends"}},
      {{"--from-local", "3;4", "--to-local", "1,1"}, {2, "EAST,NORTH"}},
      {{"--from", "146,4", "--to-local", "1,1"}, {6, "latitude out of range"}}};
  for (const auto& [arguments, expected] : cases) {
    const auto result = run(arguments);
    EXPECT_EQ(result.exit_code, expected.first) << result.err;
    EXPECT_THAT(result.err, HasSubstr(expected.second));
    EXPECT_FALSE(fs::exists(out_));
  }
}

TEST_F(RouteCommand, StraightensOnRequest) {
  const auto steps = run({"--from-local", "3,4", "--to-local", "7,4.6"});
  const auto straight = run({"--from-local", "3,4", "--to-local", "7,4.6", "--smooth"});
  ASSERT_EQ(straight.exit_code, 0) << straight.err;
  const auto a = cairn::io::parse_json(steps.out, "stdout"), b = cairn::io::parse_json(straight.out, "stdout");
  EXPECT_LT(b.at("length_m").as_real(), a.at("length_m").as_real());
  EXPECT_LE(b.at("cost").as_real(), a.at("cost").as_real() + 1e-6);
  EXPECT_GE(b.at("clearance_m").as_real(), a.at("clearance_m").as_real() - 1e-9);
}

TEST_F(RouteCommand, DrivesTheRoute) {
  const auto result = run({"--from-local", "3,4", "--to-local", "7,4", "--drive"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto drive = cairn::io::parse_json(result.out, "stdout").at("drive");
  EXPECT_EQ(drive.at("status").as_string(), "arrived");
  EXPECT_EQ(drive.at("collisions").as_integer(), 0);
  EXPECT_GT(drive.at("length_m").as_real(), 3.6);  // 4 m round the boulder, less the goal's tolerance
  EXPECT_LT(drive.at("length_m").as_real(), 7.0);
  EXPECT_GT(drive.at("time_s").as_real(), drive.at("length_m").as_real());  // at most 1 m/s
  EXPECT_GT(drive.at("scans").as_integer(), 30);
  const auto track = cairn::io::read_vehicle_csv(fs::path(out_) / "drive.csv");
  ASSERT_GT(track.size(), 30U);
  EXPECT_NEAR(track.front().position.x(), 3.0, 0.05);
  EXPECT_LT((track.back().position - cairn::geometry::Vec2(7.0, 4.0)).norm(), 1.0);
  EXPECT_EQ(run({"--from-local", "3,4", "--to-local", "7,4", "--drive"}).out, result.out);
  EXPECT_NE(run({"--from-local", "3,4", "--to-local", "7,4", "--drive", "--seed", "2"}).out, result.out);
}

TEST_F(RouteCommand, DrivesRoundWhatOnlyTheScannerSees) {
  cairn::survey::Obstacle cone;
  cone.target = cairn::survey::TargetId(7);
  cone.object_class = "cone";
  cone.position = {2.5, 6.0, 1.0};
  cone.width_m = 0.4;
  const auto hidden = (folder_ / "hidden.json").string();
  cairn::io::write_obstacles(
      hidden, {{cairn::testing::kSmallGroundOrigin, cairn::survey::HeightType::ellipsoidal, ""}, {cone}});
  const auto result = run({"--from-local", "0.6,6", "--to-local", "5,6.5", "--drive", "--hidden", hidden});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto drive = cairn::io::parse_json(result.out, "stdout").at("drive");
  EXPECT_EQ(drive.at("collisions").as_integer(), 0);
  EXPECT_GE(drive.at("replans").as_integer(), 1);
}

TEST_F(RouteCommand, TakesInLatePackets) {
  std::vector<cairn::survey::ReceivedPacket> packets;
  for (int i = 0; i < 12; ++i) {
    cairn::survey::ReceivedPacket received;
    received.packet.sequence = static_cast<std::uint32_t>(i);
    received.packet.capture_time_ns = 250'000'000LL * i;
    received.arrival_time_ns = received.packet.capture_time_ns + 1'500'000'000;
    cairn::survey::PacketObject cone;
    cone.position = {2.5, 6.0, 1.0};
    cone.covariance = cairn::geometry::Mat2::Identity() * 0.01;
    cone.size_m = 0.4;
    cone.object_class = "cone";
    cone.score = 0.9;
    received.packet.objects.push_back(cone);
    packets.push_back(received);
  }
  const auto file = (folder_ / "packets.bin").string();
  cairn::io::write_packets(file, packets);
  const auto result = run({"--from-local", "0.6,6", "--to-local", "5,6.5", "--drive", "--packets", file});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto drive = cairn::io::parse_json(result.out, "stdout").at("drive");
  EXPECT_GE(drive.at("packets").as_integer(), 6);
  EXPECT_NEAR(drive.at("mean_packet_delay_s").as_real(), 1.5, 1e-9);
  EXPECT_GE(drive.at("replans").as_integer(), 1);
}

TEST_F(RouteCommand, SaysWhatADriveLacks) {
  const auto ends = std::vector<std::string>{"--from-local", "3,4", "--to-local", "7,4"};
  const auto with = [&](std::vector<std::string> more) {
    more.insert(more.end(), ends.begin(), ends.end());
    return run(more);
  };
  EXPECT_EQ(with({"--packets", "none.bin"}).exit_code, 4);
  EXPECT_EQ(with({"--hidden", (folder_ / "obstacles.json").string()}).exit_code, 2);  // without --drive
  std::ofstream(folder_ / "cut.bin") << "not packets";
  EXPECT_EQ(with({"--drive", "--packets", (folder_ / "cut.bin").string()}).exit_code, 4);
  // The time is up before the goal: what was driven is written, and the exit code says so.
  const auto late = with({"--drive", "--time-limit-s", "2"});
  EXPECT_EQ(late.exit_code, 3);
  EXPECT_THAT(late.out, HasSubstr("\"status\": \"driving\""));
}

// Moving AI maps: every query of the scenario has its published length.
class RouteScenario : public ::testing::TestWithParam<const char*> {};

TEST_P(RouteScenario, HasThePublishedLengths) {
  constexpr double kSixDigits = 1e-5;  // relative
  const auto map = cairn::testing::test_data(std::string("movingai/") + GetParam() + ".map").string();
  const auto result = cairn({"route", map, "--scenario", map + ".scen", "--json"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto summary = cairn::io::parse_json(result.out, "stdout");
  EXPECT_GT(summary.at("queries").as_integer(), 100);
  EXPECT_EQ(summary.at("found").as_integer(), summary.at("queries").as_integer());
  EXPECT_LE(summary.at("largest_relative_difference").as_real(), kSixDigits);
}

INSTANTIATE_TEST_SUITE_P(Maps, RouteScenario, ::testing::Values("arena", "16room_000", "random512-20-0"),
                         [](const auto& test) {
                           std::string name = test.param;
                           std::replace_if(
                               name.begin(), name.end(), [](char c) { return !std::isalnum(c); }, '_');
                           return name;
                         });

TEST(RouteScenarioCommand, SaysWhatIsWrong) {
  const auto map = cairn::testing::test_data("movingai/arena.map").string();
  const auto other = cairn::testing::test_data("movingai/16room_000.map.scen").string();
  const auto mixed = cairn({"route", map, "--scenario", other});
  EXPECT_EQ(mixed.exit_code, 4);
  EXPECT_THAT(mixed.err, HasSubstr("another size"));
  EXPECT_EQ(cairn({"route", map, "-o", "x"}).exit_code, 2);
  EXPECT_EQ(cairn({"route", map + "x", "--scenario", other}).exit_code, 4);
  // Ends on blocked ground and ends that nothing joins are counted, each with its reason.
  TempFolder folder;
  std::ofstream(folder / "m.map") << "type octile\nheight 1\nwidth 5\nmap\n..@.T\n";
  std::ofstream(folder / "m.scen")
      << "version 1\n0 m 5 1 0 0 1 0 1\n0 m 5 1 0 0 3 0 3\n0 m 5 1 2 0 0 0 2\n0 m 5 1 0 0 4 0 4\n";
  const auto counted =
      cairn({"route", (folder / "m.map").string(), "--scenario", (folder / "m.scen").string(), "--json"});
  EXPECT_EQ(counted.exit_code, 3);
  const auto rejects = cairn::io::parse_json(counted.out, "stdout").at("rejects");
  for (const auto* reason : {"no_path", "start_blocked", "goal_blocked"}) EXPECT_EQ(rejects.at(reason).as_integer(), 1);
}

TEST(RouteScenarioCommand, WritesATableOfAllQueries) {
  TempFolder folder;
  const auto map = cairn::testing::test_data("movingai/arena.map").string();
  const auto result = cairn({"route", map, "--scenario", map + ".scen", "-o", (folder / "queries.csv").string()});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("160 queries, 160 found"));
  std::ifstream table(folder / "queries.csv");
  std::string line;
  std::size_t lines = 0;
  while (std::getline(table, line)) ++lines;
  EXPECT_EQ(lines, 161U);
}

}  // namespace
