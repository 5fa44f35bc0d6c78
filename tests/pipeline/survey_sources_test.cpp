// The survey's cloud as the stages get it: wrong CRS, units, places and files.
#include "pipeline/survey_sources.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "geodesy/crs.hpp"
#include "io/las.hpp"
#include "support/data.hpp"

namespace cairn::pipeline {
namespace {

namespace fs = std::filesystem;
using base::ErrorCode;
using ::testing::HasSubstr;

constexpr double kMillimetre = 1e-3;  // half a LAS scale step and the projection's own error

class SurveySources : public ::testing::Test {
 protected:
  cairn::testing::TempFolder folder_;
  survey::Survey survey_;
  geometry::PointCloud local_;
  base::RunContext ctx_;

  void SetUp() override {
    survey_.manifest.origin = {{46.8426, -91.994, 158.0}, survey::HeightType::ellipsoidal, ""};
    for (int i = 0; i < 10; ++i) local_.positions.emplace_back(3.0 * i, -2.0 * i, 0.5 * i);
  }
  // Writes the points in `crs` and declares the cloud with `declared` in the survey.
  void attach(const std::string& crs, const std::string& declared, double scale_xy = 1.0) {
    geometry::PointCloud cloud = local_;
    if (crs != "local")
      geodesy::CrsConverter(crs, geodesy::LocalFrame(survey_.manifest.origin.position)).from_local(cloud.positions);
    for (auto& p : cloud.positions) p.head<2>() *= scale_xy;
    io::LasWriteOptions options;
    if (crs != "local") options.crs = crs;
    io::write_las(folder_ / "cloud.las", cloud, options);
    survey_.manifest.sources = {{"cloud", (folder_ / "cloud.las").string(), "", survey::Confidence::declared, declared,
                                 survey::HeightType::ellipsoidal, std::nullopt}};
  }
  SurveyCloud load() { return load_cloud(folder_.path(), survey_, ctx_); }
  void expect_refusal(ErrorCode code, const char* text) {
    try {
      (void)load();
      FAIL() << "accepted";
    } catch (const base::Error& e) {
      EXPECT_EQ(e.code(), code) << e.what();
      EXPECT_THAT(e.what(), HasSubstr(text));
      EXPECT_THAT(e.what(), HasSubstr("cloud.las"));
    }
  }
};

TEST_F(SurveySources, ComesIntoThePosesFrame) {
  attach("EPSG:32615", "");
  survey_.manifest.sources[0].T_world_source = geometry::Similarity{1.0, geometry::Mat3::Identity(), {1.0, 2.0, 3.0}};
  const auto loaded = load();
  ASSERT_EQ(loaded.cloud.size(), 10U);
  for (std::size_t i = 0; i < 10; ++i)
    EXPECT_LT((loaded.cloud.positions[i] - local_.positions[i] - geometry::Vec3(1, 2, 3)).norm(), kMillimetre);
  EXPECT_FALSE(loaded.operation.empty());
}

TEST_F(SurveySources, LocalCloudsPassAsTheyAre) {
  attach("local", "local");
  EXPECT_LT((load().cloud.positions[9] - local_.positions[9]).norm(), kMillimetre);
}

TEST_F(SurveySources, WithoutCrsIsRefused) {
  attach("local", "");
  expect_refusal(ErrorCode::crs_mismatch, "declares no coordinate reference system");
}

TEST_F(SurveySources, InAnotherPlaceIsRefused) {
  attach("EPSG:32615", "EPSG:32616");
  expect_refusal(ErrorCode::crs_mismatch, "does not lie where the survey is");
}

TEST_F(SurveySources, InFeetIsRefused) {
  attach("EPSG:32615", "", 1.0 / 0.3048);
  expect_refusal(ErrorCode::crs_mismatch, "cloud");
}

TEST_F(SurveySources, EmptyIsRefused) {
  local_.positions.clear();
  attach("local", "local");
  expect_refusal(ErrorCode::invalid_input, "no points");
}

TEST_F(SurveySources, TruncatedIsRefused) {
  attach("EPSG:32615", "");
  const auto bytes = base::read_file(folder_ / "cloud.las");
  base::write_file(folder_ / "cloud.las", bytes.substr(0, bytes.size() - 5));
  expect_refusal(ErrorCode::invalid_input, "byte");
}

TEST_F(SurveySources, MissingIsRefused) {
  attach("EPSG:32615", "");
  fs::remove(folder_ / "cloud.las");
  expect_refusal(ErrorCode::not_found, "");
}

TEST_F(SurveySources, BeyondTheMemoryLimitIsRefusedBeforeItIsRead) {
  attach("EPSG:32615", "");
  ctx_.memory_limit_bytes = 1 << 20;  // less than the test program itself
  expect_refusal(ErrorCode::resource_exhausted, "memory limit");
}

TEST_F(SurveySources, NoVerticalDatumIsAWarning) {
  attach("EPSG:32615", "");
  survey_.manifest.sources[0].height_type = survey::HeightType::unknown;
  (void)load();
  ASSERT_FALSE(ctx_.warnings().empty());
  EXPECT_THAT(ctx_.warnings().back(), HasSubstr("no vertical datum"));
}

}  // namespace
}  // namespace cairn::pipeline
