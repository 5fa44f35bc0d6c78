#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <string>

#include "base/atomic_file.hpp"
#include "io/json.hpp"
#include "io/ply.hpp"
#include "io/rocks_json.hpp"
#include "io/survey_folder.hpp"
#include "io/targets_json.hpp"
#include "support/data.hpp"
#include "support/run_program.hpp"
#include "support/small_ground.hpp"

namespace {

namespace fs = std::filesystem;
using cairn::testing::cairn;
using cairn::testing::kSmallGroundOrigin;
using cairn::testing::TempFolder;
using ::testing::HasSubstr;
using ::testing::Not;

std::string text_of(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

// A block of 1 m x 1 m x 2 m on the ground at (5, 4, 1); its lower vertices lie on the plane of the contact.
cairn::geometry::TriangleMesh block() {
  cairn::geometry::TriangleMesh mesh;
  for (const double z : {1.0, 3.0})
    for (const auto& [x, y] : {std::pair{4.5, 3.5}, {5.5, 3.5}, {5.5, 4.5}, {4.5, 4.5}})
      mesh.vertices.emplace_back(x, y, z);
  mesh.triangles = {{0, 2, 1}, {0, 3, 2}, {4, 5, 6}, {4, 6, 7}};
  for (std::uint32_t i = 0; i < 4; ++i) {
    const std::uint32_t j = (i + 1) % 4;
    mesh.triangles.push_back({i, j, j + 4});
    mesh.triangles.push_back({i, j + 4, i + 4});
  }
  return mesh;
}

class ReportCommand : public ::testing::Test {
 protected:
  TempFolder folder_;
  fs::path results_ = folder_ / "results", survey_ = folder_ / "survey", out_ = folder_ / "report";
  const ::cairn::survey::Origin origin_{kSmallGroundOrigin, ::cairn::survey::HeightType::ellipsoidal, ""};

  void SetUp() override {
    fs::create_directories(results_ / "rocks");
    fs::create_directories(survey_);
    ::cairn::testing::write_small_ground(results_);
    ::cairn::survey::Target target;
    target.id = ::cairn::survey::TargetId(1);
    target.object_class = "boulder";
    target.state = ::cairn::survey::TargetState::mapped;
    target.centre = {5.0, 4.0, 2.0};
    target.covariance = 1e-4 * ::cairn::geometry::Mat3::Identity();
    ::cairn::io::write_targets(results_ / "targets.json", {origin_, {target}});
    write_rock(::cairn::survey::Grade::screening);
    ::cairn::io::write_ply(results_ / "rocks/1.ply", block());
    ::cairn::base::write_file(results_ / "route.json",
                              R"({"path_m": [[1, 1], [2, 6]], "length_m": 5.1, "clearance_m": 0.7})");

    ::cairn::survey::Survey survey;
    survey.manifest.name = "small ground";
    survey.manifest.origin = origin_;
    ::cairn::survey::Camera camera;
    camera.id = ::cairn::survey::CameraId(1);
    camera.width_px = 400;
    camera.height_px = 300;
    camera.fx_px = camera.fy_px = 300.0;
    camera.cx_px = 200.0;
    camera.cy_px = 150.0;
    survey.manifest.cameras = {camera};
    ::cairn::survey::Frame frame;
    frame.id = ::cairn::survey::FrameId(7);
    frame.camera = camera.id;
    frame.image = "photo_7.jpg";
    frame.T_world_camera.rotation << 1, 0, 0, 0, -1, 0, 0, 0, -1;
    frame.T_world_camera.translation = {5.0, 4.0, 30.0};
    survey.frames = {frame};
    ::cairn::io::write_survey(survey, survey_);
  }

  void write_rock(::cairn::survey::Grade grade) const {
    ::cairn::survey::Rock rock;
    rock.target = ::cairn::survey::TargetId(1);
    rock.object_class = "boulder";
    rock.point_count = 120;
    rock.size_m = {1.0, 1.0, 2.0};
    rock.base_height_m = 1.0;
    rock.cap = ::cairn::survey::CapModel::plane;
    rock.mass = ::cairn::geometry::mass_properties(block());
    rock.unseen_area_fraction = 0.9;
    rock.tipping.grade = grade;
    rock.tipping.reasons = {"contact_assumed"};
    rock.tipping.contact = {{4.5, 3.5, 1}, {5.5, 3.5, 1}, {5.5, 4.5, 1}, {4.5, 4.5, 1}};
    if (grade != ::cairn::survey::Grade::not_measurable) {
      rock.tipping.critical = ::cairn::survey::TippingEdge{90.0, 0.4636476, 1.118034, 2.5, 0.5, 2.2};
      rock.tipping.a_qs_g_by_azimuth.assign(360, 0.5);
    }
    ::cairn::io::write_rocks(results_ / "rocks.json", {origin_, {rock}});
  }

  [[nodiscard]] ::cairn::testing::ProgramResult run(std::vector<std::string> more = {}) const {
    std::vector<std::string> arguments{"report", results_.string(), "-o", out_.string(), "--json"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return cairn(arguments);
  }
};

TEST_F(ReportCommand, WritesOnePageOfEverythingThatIsThere) {
  const auto result = run({"--survey", survey_.string(), "--title", "Two <b>rocks</b>"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto summary = ::cairn::io::parse_json(result.out, "stdout");
  EXPECT_EQ(summary.at("objects").as_integer(), 1);
  EXPECT_EQ(summary.at("meshes").as_integer(), 1);
  const std::string page = text_of(out_ / "index.html");
  EXPECT_EQ(static_cast<std::int64_t>(page.size()), summary.at("bytes").as_integer());
  EXPECT_THAT(page, HasSubstr("Two &lt;b&gt;rocks&lt;/b&gt;"));
  EXPECT_THAT(page, HasSubstr("photo_7.jpg"));
  EXPECT_THAT(page, HasSubstr("class=\"footprint\""));
  EXPECT_THAT(page, HasSubstr("26.6")) << "the tipping angle of the block, atan(1/2)";
  EXPECT_THAT(page, Not(HasSubstr("data-layer=\"costmap\"")));
  EXPECT_THAT(page, Not(HasSubstr(folder_.path().string()))) << "no path of this machine";
  EXPECT_TRUE(fs::exists(out_ / "run.json"));
}

TEST_F(ReportCommand, TheSameResultsGiveTheSameBytes) {
  ASSERT_EQ(run({"--survey", survey_.string(), "--threads", "1"}).exit_code, 0);
  const std::string first = text_of(out_ / "index.html");
  ASSERT_EQ(run({"--survey", survey_.string(), "--threads", "4", "--overwrite"}).exit_code, 0);
  EXPECT_EQ(text_of(out_ / "index.html"), first);
}

TEST_F(ReportCommand, ARockThatIsNotMeasurableHasNoAngle) {
  write_rock(::cairn::survey::Grade::not_measurable);
  ASSERT_EQ(run({"--survey", survey_.string()}).exit_code, 0);
  const std::string page = text_of(out_ / "index.html");
  EXPECT_THAT(page, HasSubstr("No tipping figure is given"));
  EXPECT_THAT(page, Not(HasSubstr("class=\"polar\"")));
}

TEST_F(ReportCommand, WithoutASurveyItWarnsAndReportsTheRest) {
  const auto result = run();
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.err, HasSubstr("--survey"));
  EXPECT_THAT(text_of(out_ / "index.html"), HasSubstr("46.8426"));
}

TEST_F(ReportCommand, AFolderWithoutProductsIsInvalidInput) {
  fs::create_directories(folder_ / "empty");
  const auto result = cairn({"report", (folder_ / "empty").string(), "-o", out_.string()});
  EXPECT_EQ(result.exit_code, 4);
  EXPECT_THAT(result.err, HasSubstr("nothing to report"));
  EXPECT_EQ(cairn({"report", (folder_ / "absent").string(), "-o", out_.string()}).exit_code, 4);
  EXPECT_FALSE(fs::exists(out_));
}

TEST_F(ReportCommand, ABrokenProductIsNamedAndNothingIsWritten) {
  ::cairn::base::write_file(results_ / "rocks.json", "{\"schema_version\": 1, ");
  const auto result = run();
  EXPECT_EQ(result.exit_code, 4);
  EXPECT_THAT(result.err, HasSubstr("rocks.json"));
  EXPECT_FALSE(fs::exists(out_));
}

TEST_F(ReportCommand, AnotherSurveysFrameIsRefused) {
  auto survey = ::cairn::io::read_survey(survey_);
  survey.manifest.origin.position.latitude_deg += 0.5;
  ::cairn::io::write_survey(survey, survey_);
  EXPECT_EQ(run({"--survey", survey_.string()}).exit_code, 6);
}

TEST_F(ReportCommand, AnExistingReportIsKept) {
  ASSERT_EQ(run().exit_code, 0);
  EXPECT_EQ(run().exit_code, 7);
  EXPECT_EQ(run({"--overwrite"}).exit_code, 0);
}

TEST_F(ReportCommand, AnOptionOutOfRangeIsAUsageError) {
  EXPECT_EQ(run({"--max-raster-px", "3"}).exit_code, 2);
}

}  // namespace
