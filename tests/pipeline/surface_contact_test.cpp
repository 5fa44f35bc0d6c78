// Contact lines on their way into closed surfaces and records.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/error.hpp"
#include "base/run_context.hpp"
#include "io/cloud.hpp"
#include "io/contact_csv.hpp"
#include "io/json.hpp"
#include "pipeline/surface_stage.hpp"
#include "support/data.hpp"
#include "support/rock_scan.hpp"

namespace cairn::pipeline {
namespace {

namespace fs = std::filesystem;

class SurfaceContact : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    testing::RockScanOptions options;
    options.height_m = 0.9;
    options.spacing_m = 0.02;
    scan_ = testing::make_rock_scan(3, options);
  }
  void SetUp() override {
    cloud_ = folder_ / "x.las";
    io::write_cloud(cloud_, scan_.labelled(), {});
  }
  io::Json record(const SurfaceFiles& files) {
    const fs::path out = folder_ / "out";
    fs::remove_all(out);
    fs::create_directories(out);
    base::RunContext ctx;
    const auto outcome = surface_file(files, out, {}, ctx);
    EXPECT_EQ(outcome.summary.at("rocks").as_integer(), 1);
    return io::read_json(out / "1.json");
  }
  void write_line(const fs::path& path, const geometry::Vec3& shift, const std::string& crs) {
    io::ContactFile file;
    file.crs = crs;
    for (auto vertex : scan_.contact()) {
      vertex.position += shift;
      vertex.sigma_m = 0.03;
      file.rows.push_back({1, vertex});
    }
    io::write_contact_csv(path, file);
  }

  static testing::RockScan scan_;
  testing::TempFolder folder_;
  fs::path cloud_;
};

testing::RockScan SurfaceContact::scan_;

TEST_F(SurfaceContact, LineBesideTheCloudIsTakenAsItIs) {
  write_line(folder_ / "x.contact.csv", geometry::Vec3::Zero(), "local");
  const auto json = record({cloud_, {}});
  EXPECT_FALSE(json.at("contact").at("assumed").as_bool());
  const auto& line = json.at("contact").at("line").as_array();
  const auto truth = scan_.contact();
  ASSERT_EQ(line.size(), truth.size());
  for (std::size_t i = 0; i < line.size(); ++i) {
    EXPECT_EQ(line[i].at("position_m").as_vec3(), truth[i].position);
    EXPECT_EQ(line[i].at("status").as_string(), "observed");
  }
  const auto& surface = json.at("surface");
  EXPECT_EQ(surface.at("method").as_string(), "implicit");
  EXPECT_EQ(surface.at("cap").at("model").as_string(), "patch");
  EXPECT_GE(surface.at("cap").at("h_c_m").as_real(), 0.03);
  EXPECT_EQ(json.at("rock").at("cap_height_sigma_m").as_real(), surface.at("cap").at("h_c_m").as_real());
  EXPECT_NEAR(surface.at("noise_m").as_real(), scan_.noise_m, 0.3 * scan_.noise_m);
  EXPECT_NEAR(json.at("rock").at("mass").at("volume_m3").as_real() / scan_.mass.volume, 1.0, 0.02);
}

TEST_F(SurfaceContact, WithoutALineTheLabelsShowIt) {
  const auto json = record({cloud_, {}});
  EXPECT_FALSE(json.at("contact").at("assumed").as_bool());
  EXPECT_GE(json.at("contact").at("line").size(), 8U);
  EXPECT_NEAR(json.at("rock").at("mass").at("volume_m3").as_real() / scan_.mass.volume, 1.0, 0.03);
}

TEST_F(SurfaceContact, LineElsewhereIsNotUsed) {
  const fs::path far = folder_ / "far.csv";
  write_line(far, {5.0, 0.0, 0.0}, "local");
  const auto json = record({cloud_, far});
  EXPECT_TRUE(json.at("contact").at("assumed").as_bool());
  bool told = false;
  for (const auto& note : json.at("surface").at("notes").as_array())
    told = told || note.as_string() == "contact_outside_rock";
  EXPECT_TRUE(told);
}

TEST_F(SurfaceContact, LineInAnotherCrsIsRefused) {
  const fs::path other = folder_ / "other.csv";
  write_line(other, geometry::Vec3::Zero(), "EPSG:32611");
  base::RunContext ctx;
  try {
    (void)surface_file({cloud_, other}, folder_ / "out", {}, ctx);
    FAIL() << "no error";
  } catch (const base::Error& error) {
    EXPECT_EQ(error.code(), base::ErrorCode::crs_mismatch);
  }
}

}  // namespace
}  // namespace cairn::pipeline
