// Paper B's chain through the program: a drive is simulated and recorded, then every command runs again on the record.
#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "io/json.hpp"
#include "support/data.hpp"
#include "support/run_program.hpp"

namespace {

namespace fs = std::filesystem;
using cairn::testing::cairn;
using cairn::testing::sample;
using cairn::testing::TempFolder;

constexpr double kFiltered_m = 0.8;    // RMS of the filtered track over the whole record, its first seconds included
constexpr double kWayRound_m = 45.0;   // the shortest way through the park is 35 m, the way round 55 m
constexpr std::int64_t kBlockers = 8;  // cones and bushes across the shortest way

cairn::io::Json summary(const std::vector<std::string>& arguments) {
  const auto result = cairn(arguments);
  EXPECT_EQ(result.exit_code, 0) << result.err;
  return cairn::io::parse_json(result.exit_code == 0 ? result.out : "{}", "stdout");
}

TEST(GroundVehicle, EveryCommandRunsOnARecordedDrive) {
  const TempFolder folder;
  const auto path = [&](const char* name) { return (folder / name).string(); };
  const auto drive = summary(
      {"simulate", sample("scenes/park.json").string(), "--drive", "--seed", "1", "-o", path("survey"), "--json"});
  ASSERT_NE(drive.find("arrived"), nullptr);
  EXPECT_TRUE(drive.at("arrived").as_bool());
  EXPECT_EQ(drive.at("contacts").as_integer(), 0);

  const auto seen =
      summary({"obstacles", path("survey"), "--no-locate", "--ground-up-m", "0", "-o", path("seen"), "--json"});
  EXPECT_GE(seen.at("obstacle").as_integer(), kBlockers);

  const auto track =
      summary({"vehicle", path("survey"), "--packets", path("survey/packets.bin"), "-o", path("track"), "--json"});
  EXPECT_LT(track.at("errors").at("filter").at("rms_m").as_real(), kFiltered_m);

  static_cast<void>(
      summary({"costmap", "--prior", path("survey/prior/map.yaml"), "--obstacles", path("seen/layers.gpkg"), "--scans",
               path("survey/lidar.csv"), "--vehicle", path("track/vehicle.csv"), "-o", path("cost"), "--json"}));
  const auto route = summary({"route", path("cost/costmap.tif"), "--from-local", "2,10", "--to-local", "27.5,10",
                              "--drive", "-o", path("route"), "--json"});
  // The obstacles that the aircraft saw send the route the way round.
  EXPECT_GT(route.at("length_m").as_real(), kWayRound_m);
  EXPECT_EQ(route.at("drive").at("status").as_string(), "arrived");
  EXPECT_EQ(route.at("drive").at("collisions").as_integer(), 0);
}

}  // namespace
