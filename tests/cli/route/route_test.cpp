#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "base/number_text.hpp"
#include "io/json.hpp"
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

}  // namespace
