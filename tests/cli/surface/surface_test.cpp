#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

#include "geometry/mass_properties.hpp"
#include "io/json.hpp"
#include "io/ply.hpp"
#include "support/data.hpp"
#include "support/run_program.hpp"
#include "support/small_rocks.hpp"

namespace {

namespace fs = std::filesystem;
using cairn::testing::cairn;
using cairn::testing::TempFolder;
using ::testing::HasSubstr;

class SurfaceCommand : public ::testing::Test {
 protected:
  TempFolder folder_;
  std::string cloud_ = (folder_ / "cloud.las").string(), labelled_ = (folder_ / "labelled.las").string(),
              out_ = (folder_ / "surfaces").string();
  void SetUp() override {
    ::cairn::testing::write_small_rocks(folder_.path());
    const auto result = cairn({"segment", cloud_, "--targets", (folder_ / "targets.json").string(), "-o", labelled_});
    ASSERT_EQ(result.exit_code, 0) << result.err;
  }
};

TEST_F(SurfaceCommand, ClosedMeshesWithMassAndQuality) {
  const auto result = cairn({"surface", labelled_, "-o", out_, "--json"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto summary = ::cairn::io::parse_json(result.out, "stdout");
  EXPECT_EQ(summary.at("rocks").as_integer(), 2);
  const struct {
    const char* id;
    const char* method;
    double volume, tolerance;
  } expected[] = {{"1", "top", 2.0 / 3.0 * std::numbers::pi * .5 * .4 * .35, 0.2},
                  {"2", "implicit", std::numbers::pi * .25 * 1.2, 0.04}};
  for (const auto& rock : expected) {
    const fs::path stem = fs::path(out_) / rock.id;
    const auto json = ::cairn::io::read_json(stem.string() + ".json");
    EXPECT_EQ(json.at("surface").at("method").as_string(), rock.method);
    EXPECT_TRUE(json.at("surface").at("quality").at("watertight").as_bool());
    const double volume = json.at("rock").at("mass").at("volume_m3").as_real();
    EXPECT_NEAR(volume / rock.volume, 1.0, rock.tolerance) << rock.id;
    EXPECT_GE(json.at("rock").at("hull_volume_m3").as_real(), volume);
    const auto mesh = ::cairn::io::read_ply_mesh(stem.string() + ".ply").mesh;
    EXPECT_TRUE(::cairn::geometry::topology(mesh).closed());
    EXPECT_NEAR(::cairn::geometry::mass_properties(mesh).volume, volume, 1e-12);
    EXPECT_TRUE(fs::exists(stem.string() + ".glb"));
    EXPECT_GE(json.at("contact").at("line").size(), 4U);
  }
  EXPECT_TRUE(fs::exists(fs::path(out_) / "run.json"));
}

TEST_F(SurfaceCommand, BadInput) {
  const auto unlabelled = cairn({"surface", cloud_, "-o", out_});
  EXPECT_EQ(unlabelled.exit_code, 4);
  EXPECT_THAT(unlabelled.err, HasSubstr("no column 'label'"));
  EXPECT_EQ(cairn({"surface", labelled_, "-o", out_, "--method", "magic"}).exit_code, 2);
  EXPECT_FALSE(fs::exists(out_));
}

}  // namespace
