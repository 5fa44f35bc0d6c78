#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>

#include "base/atomic_file.hpp"
#include "io/image.hpp"
#include "io/json.hpp"
#include "io/survey_folder.hpp"
#include "io/truth.hpp"
#include "support/data.hpp"
#include "support/run_program.hpp"

namespace {

namespace fs = std::filesystem;
using cairn::testing::cairn;
using cairn::testing::sample;
using cairn::testing::TempFolder;
using ::testing::HasSubstr;

const fs::path kTiny = sample("scenes/tiny.json");

// Content of every file below a folder but run.json, which holds times.
std::map<std::string, std::string> contents(const fs::path& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.is_regular_file() && entry.path().filename() != "run.json")
      files[entry.path().lexically_relative(folder).generic_string()] = cairn::base::read_file(entry.path());
  return files;
}

TEST(SimulateCommand, SameSeedSameBytesOnAnyNumberOfThreads) {
  const TempFolder folder;
  const auto run = [&](const std::string& name, const std::string& seed, const std::string& threads) {
    const auto result = cairn(
        {"simulate", kTiny.string(), "--seed", seed, "--threads", threads, "-o", (folder / name).string(), "--quiet"});
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return contents(folder / name);
  };
  const auto a = run("a", "7", "1"), b = run("b", "7", "4"), c = run("c", "8", "4");
  ASSERT_GT(a.size(), 100U);
  EXPECT_EQ(a, b);
  EXPECT_NE(a.at("detections.csv"), c.at("detections.csv"));
  EXPECT_EQ(a.at("truth/frames.csv"), c.at("truth/frames.csv"));
  EXPECT_EQ(a.at("truth/boxes.csv"), c.at("truth/boxes.csv"));
}

class TinySurvey : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TempFolder;
    const auto result = cairn({"simulate", kTiny.string(), "--seed", "1", "-o", survey().string(), "--json"});
    ASSERT_EQ(result.exit_code, 0) << result.err;
    summary_ = new ::cairn::io::Json(::cairn::io::parse_json(result.out, "stdout"));
  }
  static void TearDownTestSuite() {
    delete folder_;
    delete summary_;
  }
  static fs::path survey() { return *folder_ / "survey"; }
  static TempFolder* folder_;
  static ::cairn::io::Json* summary_;
};
TempFolder* TinySurvey::folder_ = nullptr;
::cairn::io::Json* TinySurvey::summary_ = nullptr;

TEST_F(TinySurvey, HoldsWhatItsSummaryCounts) {
  const auto survey = ::cairn::io::read_survey(TinySurvey::survey());
  const auto truth = ::cairn::io::read_truth(TinySurvey::survey() / "truth.json");
  EXPECT_EQ(summary_->at("frames").as_integer(), static_cast<std::int64_t>(survey.frames.size()));
  EXPECT_EQ(summary_->at("detections").as_integer(), static_cast<std::int64_t>(survey.detections.size()));
  EXPECT_EQ(summary_->at("true_boxes").as_integer(), static_cast<std::int64_t>(truth.boxes.size()));
  EXPECT_EQ(truth.seed, 1U);
  ASSERT_EQ(truth.objects.size(), 4U);
  EXPECT_EQ(truth.objects[0].object_class, "pbr");
  EXPECT_TRUE(truth.objects[0].sought);
  EXPECT_FALSE(truth.objects[0].contact_rim.empty());
  EXPECT_EQ(truth.frames.size(), survey.frames.size());
  EXPECT_EQ(truth.detections.size(), survey.detections.size());
  for (const auto& object : truth.objects) EXPECT_TRUE(fs::exists(TinySurvey::survey() / object.mesh));
}

TEST_F(TinySurvey, MasksShowTheObjectsInTheirTrueBoxes) {
  const auto truth = ::cairn::io::read_truth(TinySurvey::survey() / "truth.json");
  const auto overlaps = [](const auto& a, const auto& b) {
    return a.frame == b.frame && a.object != b.object && a.box.xmin < b.box.xmax && b.box.xmin < a.box.xmax &&
           a.box.ymin < b.box.ymax && b.box.ymin < a.box.ymax;
  };
  std::size_t tested = 0;
  for (const auto& box : truth.boxes) {
    if (box.visible_share < 1.0) continue;
    // The share is sampled: an object that another may hide in part is left out.
    if (std::any_of(truth.boxes.begin(), truth.boxes.end(), [&](const auto& b) { return overlaps(box, b); })) continue;
    const auto number = std::to_string(box.frame.value);
    const auto mask = ::cairn::io::read_grey16_png(TinySurvey::survey() / "masks" /
                                                   (std::string(6 - number.size(), '0') + number + ".png"));
    double xmin = 1e9, ymin = 1e9, xmax = -1, ymax = -1;
    for (std::int64_t v = 0; v < mask.height_px; ++v)
      for (std::int64_t u = 0; u < mask.width_px; ++u) {
        if (mask.values[static_cast<std::size_t>(v * mask.width_px + u)] != box.object.value + 1) continue;
        xmin = std::min(xmin, static_cast<double>(u));
        ymin = std::min(ymin, static_cast<double>(v));
        xmax = std::max(xmax, static_cast<double>(u) + 1.0);
        ymax = std::max(ymax, static_cast<double>(v) + 1.0);
      }
    if (box.box.area() < 100.0) continue;  // px^2: thin tips fall between rays
    ++tested;
    constexpr double kPixel = 3.0;  // px: corners of a faceted body, like a tree's tip, end thinner than a pixel
    EXPECT_NEAR(box.box.xmin, xmin, kPixel) << "frame " << number << " object " << box.object.value;
    EXPECT_NEAR(box.box.xmax, xmax, kPixel) << "frame " << number << " object " << box.object.value;
    EXPECT_NEAR(box.box.ymax, ymax, kPixel) << "frame " << number << " object " << box.object.value;
  }
  EXPECT_GT(tested, 20U);
}

TEST_F(TinySurvey, PassesCheckAndGoesThroughLocate) {
  const auto check = cairn({"check", survey().string(), "--json"});
  EXPECT_EQ(check.exit_code, 0) << check.out << check.err;
  const fs::path out = *folder_ / "located";
  const auto locate = cairn({"locate", survey().string(), "-o", out.string(), "--json", "--quiet"});
  ASSERT_EQ(locate.exit_code, 0) << locate.err;
  EXPECT_GE(::cairn::io::parse_json(locate.out, "stdout").at("converged").as_integer(), 1);
}

TEST_F(TinySurvey, IsNotReplacedUnasked) {
  EXPECT_EQ(cairn({"simulate", kTiny.string(), "-o", survey().string()}).exit_code, 7);
}

TEST(SimulateCommand, DryRunWritesNothing) {
  const TempFolder folder;
  const auto result = cairn({"simulate", kTiny.string(), "-o", (folder / "out").string(), "--dry-run", "--json"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_GT(::cairn::io::parse_json(result.out, "stdout").at("pictures").as_integer(), 0);
  EXPECT_FALSE(fs::exists(folder / "out"));
}

struct BadScene {
  const char* what;
  const char* from;  // text of tiny.json that is replaced
  const char* to;
  const char* record;  // that the error names
};

class BadScenes : public ::testing::TestWithParam<BadScene> {};

TEST_P(BadScenes, AreRefusedWithThePathOfTheMember) {
  const BadScene& bad = GetParam();
  std::string text = ::cairn::base::read_file(kTiny);
  const auto at = text.find(bad.from);
  ASSERT_NE(at, std::string::npos);
  text.replace(at, std::string(bad.from).size(), bad.to);
  const TempFolder folder;
  ::cairn::base::write_file(folder / "scene.json", text);
  const auto result = cairn({"simulate", (folder / "scene.json").string(), "-o", (folder / "out").string(), "--json"});
  EXPECT_EQ(result.exit_code, 4) << result.err;
  EXPECT_THAT(result.err, HasSubstr("scene.json"));
  EXPECT_THAT(result.err, HasSubstr(bad.record)) << bad.what;
  EXPECT_FALSE(fs::exists(folder / "out"));
}

INSTANTIATE_TEST_SUITE_P(
    SimulateCommand, BadScenes,
    ::testing::Values(
        BadScene{"unknown member", "\"cell_m\": 0.5", "\"cel_m\": 0.5", "terrain.cel_m"},
        BadScene{"unknown version", "\"schema_version\": 1", "\"schema_version\": 9", "schema_version"},
        BadScene{"wrong kind", "\"height_m\": 10", "\"height_m\": \"high\"", "flights[0].height_m"},
        BadScene{"missing", "\"class\": \"boulder\", ", "", "objects[1].class"},
        BadScene{"unknown name", "\"kind\": \"orbit\"", "\"kind\": \"loop\"", "flights[1].kind"},
        BadScene{"out of range", "\"miss_rate\": 0.1", "\"miss_rate\": 1.5", "detector.miss_rate"},
        BadScene{"not a number", "\"position\": [4, -3]", "\"position\": [4, \"x\"]", "objects[1].position"},
        BadScene{"two places", "\"position\": [4, -3]",
                 "\"position\": [4, -3], \"scatter\": {\"area\": [[0, 0], [1, 1]]}", "objects[1]"},
        BadScene{"no area", "[[-6, -6], [6, 6]]", "[[-6, -6], [-6, 6]]", "flights[0].area"},
        BadScene{"unknown object", "\"about\": \"PBR\"", "\"about\": \"ABC\"", "flights[1].about"},
        BadScene{"off the ground", "\"position\": [4, -3]", "\"position\": [400, -3]", "does not stand on the ground"},
        BadScene{"unknown family", "\"family\": \"conifer\"", "\"family\": \"palm\"", "palm"},
        BadScene{"no file", "\"kind\": \"fractal\"", "\"kind\": \"mesh\", \"file\": \"no.ply\"", "no.ply"},
        BadScene{"not JSON", "\"terrain\":", "\"terrain\"", "line"}),
    [](const auto& param) {
      std::string name = param.param.what;
      std::replace(name.begin(), name.end(), ' ', '_');
      return name;
    });

TEST(SimulateCommand, DrivesInClosedLoopAndRecordsIt) {
  const TempFolder folder;
  const fs::path scene = sample("scenes/football_field.json");
  const auto run = [&](const std::string& name, const std::string& threads) {
    const auto result = cairn({"simulate", scene.string(), "--drive", "--seed", "2", "--threads", threads, "-o",
                               (folder / name).string(), "--json"});
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return ::cairn::io::parse_json(result.out, "stdout");
  };
  const auto summary = run("a", "1");
  EXPECT_TRUE(summary.at("arrived").as_bool());
  EXPECT_EQ(summary.at("contacts").as_integer(), 0);
  static_cast<void>(run("b", "2"));
  EXPECT_EQ(contents(folder / "a"), contents(folder / "b"));
  for (const char* name : {"vehicle.csv", "lidar.csv", "packets.bin", "truth/vehicle.csv", "prior/map.yaml",
                           "drive/drive.json", "drive/paths.svg"})
    EXPECT_TRUE(fs::exists(folder / "a" / name)) << name;
}

TEST(SimulateCommand, NoAerialNeedsADrive) {
  const TempFolder folder;
  const auto result = cairn({"simulate", kTiny.string(), "--no-aerial", "-o", (folder / "x").string()});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.err, HasSubstr("--drive"));
}

TEST(SimulateCommand, ADriveNeedsAVehicle) {
  const TempFolder folder;
  const auto result = cairn({"simulate", kTiny.string(), "--drive", "-o", (folder / "x").string()});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.err, HasSubstr("drive"));
  EXPECT_FALSE(fs::exists(folder / "x"));
}

}  // namespace
