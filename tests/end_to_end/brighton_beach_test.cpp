// The main job on the real survey, through the program, with limits: import, check, run, resume,
// determinism, kill, and other people's readers.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "base/atomic_file.hpp"
#include "base/digest.hpp"
#include "camera/projection.hpp"
#include "io/csv.hpp"
#include "io/json.hpp"
#include "io/raster.hpp"
#include "io/survey_folder.hpp"
#include "io/targets_json.hpp"
#include "support/data.hpp"
#include "support/run_program.hpp"

namespace {

namespace fs = std::filesystem;
using cairn::testing::cairn;
using cairn::testing::run_program;
using cairn::testing::sample;
using cairn::testing::source_dir;
using cairn::testing::TempFolder;
using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

const fs::path kRecipe = source_dir() / "pipelines/post_flight.json";

const std::vector<std::string> kProducts = {"targets.json",   "layers.gpkg",       "surface.tif", "views.tif",
                                            "costmap.tif",    "map.yaml",          "map.pgm",     "rocks.json",
                                            "obstacles.json", "inventory.csv",     "gaps.json",   "route.json",
                                            "coverage.json",  "report/index.html", "run.json"};

// One survey and one finished job for all tests of this file.
class BrightonBeach : public ::testing::Test {
 public:
  static void SetUpTestSuite() {
    folder_ = new TempFolder;
    const auto import = import_survey();
    ASSERT_EQ(import.exit_code, 0) << import.err;
    const auto run = run_job(out(), {"--threads", "2"});
    ASSERT_EQ(run.exit_code, 0) << run.err;
  }
  static void TearDownTestSuite() { delete folder_; }

 protected:
  static fs::path survey() { return *folder_ / "survey"; }
  static fs::path out() { return *folder_ / "out"; }

  static cairn::testing::ProgramResult import_survey() {
    const auto in = sample("brighton_beach");
    return cairn({"import", "colmap", (in / "colmap_enu").string(), "--images", (in / "images_1600").string(),
                  "--origin", "46.8426,-91.9940,158.0", "--height-type", "ellipsoidal", "--scale-images", "0.4",
                  "--detections", (in / "detections.csv").string(), "--cloud", (in / "model.las").string(),
                  "--similarity", (in / "enu_frame.json").string(), "-o", survey().string()});
  }
  static std::vector<std::string> job(const fs::path& to, const std::vector<std::string>& more = {}) {
    std::vector<std::string> arguments{"run", kRecipe.string(), survey().string(), "-o", to.string()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  }
  static cairn::testing::ProgramResult run_job(const fs::path& to, const std::vector<std::string>& more = {}) {
    return cairn(job(to, more));
  }

 private:
  static inline TempFolder* folder_ = nullptr;
};

// Content of every product; run.json and the state folder hold times.
std::map<std::string, std::string> contents(const fs::path& folder) {
  std::map<std::string, std::string> digests;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    const std::string name = fs::relative(entry.path(), folder).string();
    if (!entry.is_regular_file() || name == "run.json" || name.starts_with(".cairn/")) continue;
    digests[name] = cairn::base::sha256_of_file(entry.path());
  }
  return digests;
}

// Names of the products that differ, or are in one folder only.
std::vector<std::string> differing(const std::map<std::string, std::string>& a,
                                   const std::map<std::string, std::string>& b) {
  std::set<std::string> names;
  for (const auto& [name, digest] : a)
    if (!b.contains(name) || b.at(name) != digest) names.insert(name);
  for (const auto& [name, digest] : b)
    if (!a.contains(name)) names.insert(name);
  return {names.begin(), names.end()};
}

TEST_F(BrightonBeach, TheSurveyIsSound) {
  const auto result = cairn({"check", survey().string(), "--json"});
  EXPECT_EQ(result.exit_code, 0) << result.out;
  EXPECT_TRUE(cairn::io::parse_json(result.out, "check").at("ok").as_bool());
}

TEST_F(BrightonBeach, EveryProductIsThere) {
  for (const auto& name : kProducts) EXPECT_TRUE(fs::exists(out() / name)) << name;
  std::size_t models = 0;
  for (const auto& entry : fs::directory_iterator(out() / "rocks"))
    models += entry.path().extension() == ".glb" ? 1U : 0U;
  EXPECT_GE(models, 10U);
}

struct Object {
  std::string id, object_class;
  cairn::geometry::Vec3 p_world;
};

std::vector<Object> objects() {
  cairn::io::CsvReader table(sample("brighton_beach/objects.csv"));
  const auto id = table.column("object_id"), object_class = table.column("class"), east = table.column("east_m"),
             north = table.column("north_m"), up = table.column("up_m");
  std::vector<Object> list;
  while (table.next())
    list.push_back({std::string(table.text(id)),
                    std::string(table.text(object_class)),
                    {table.real(east), table.real(north), table.real(up)}});
  return list;
}

// Photographs in which a box of the object's class holds the object's projection.
std::size_t photos_showing(const cairn::survey::Survey& survey, const Object& object) {
  std::set<cairn::survey::FrameId> frames;
  for (const auto& box : survey.detections) {
    const auto* frame = survey.frame(box.frame);
    const auto pixel =
        cairn::camera::project_world(*survey.camera(frame->camera), frame->T_world_camera, object.p_world);
    if (box.object_class == object.object_class && pixel && box.box.contains(*pixel)) frames.insert(box.frame);
  }
  return frames.size();
}

TEST_F(BrightonBeach, ObjectsAreLocatedWithinTheLimits) {
  constexpr double kMatch_m = 1.5;
  const auto survey = cairn::io::read_survey(this->survey());
  const auto targets = cairn::io::read_targets(out() / "targets.json").targets;
  std::size_t shown = 0;
  std::vector<double> errors;
  for (const auto& object : objects()) {
    if (photos_showing(survey, object) < 3) continue;
    ++shown;
    double nearest = kMatch_m;
    for (const auto& target : targets)
      if (target.object_class == object.object_class && target.state != cairn::survey::TargetState::deregistered)
        nearest = std::min(nearest, (target.centre - object.p_world).head<2>().norm());
    if (nearest < kMatch_m) errors.push_back(nearest);
  }
  ASSERT_GE(shown, 30U);
  std::sort(errors.begin(), errors.end());
  EXPECT_GE(static_cast<double>(errors.size()), 0.95 * static_cast<double>(shown));
  EXPECT_LE(errors[errors.size() / 2], 0.10) << "median, m";
  EXPECT_LE(errors[static_cast<std::size_t>(std::ceil(0.95 * static_cast<double>(errors.size()))) - 1], 0.30)
      << "95 %, m";
}

// The audit by itself: a nadir flight at 40 m shows lawns and tops, and no wall.
TEST_F(BrightonBeach, TheAuditPassesLawnsAndFailsWalls) {
  const TempFolder elsewhere;
  const fs::path to = elsewhere / "audit";
  const auto run = cairn({"run", (source_dir() / "pipelines/coverage_audit.json").string(), survey().string(), "-o",
                          to.string(), "--threads", "2"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  for (const char* name : {"audit.html", "coverage.gpkg", "coverage.glb", "coverage.ply", "facets.csv", "views.tif"})
    EXPECT_TRUE(fs::exists(to / name)) << name;
  const auto json = cairn::io::read_json(to / "coverage.json");
  EXPECT_GE(json.at("completeness").as_real(), 0.95);
  EXPECT_GE(json.at("completeness_interval_95").as_array()[0].as_real(), 0.9);
  EXPECT_LT(json.at("sides").at("completeness").as_real(), 0.9);
  std::map<std::int64_t, std::string> classes;
  for (const auto& target : cairn::io::read_targets(to / "targets.json").targets)
    classes[target.id.value] = target.object_class;
  cairn::io::CsvReader csv(to / "targets_coverage.csv");
  std::size_t boulders = 0;
  while (csv.next()) {
    EXPECT_EQ(csv.text(csv.column("passed")), "false");
    EXPECT_EQ(csv.real(csv.column("basal_seen_share")), 0.0);
    if (classes.at(csv.integer(csv.column("target_id"))) != "boulder") continue;
    ++boulders;
    EXPECT_LT(csv.real(csv.column("wall_completeness")), 0.2);
  }
  EXPECT_GE(boulders, 10U);
}

TEST_F(BrightonBeach, NoAngleIsPrintedForARockThatCannotBeMeasured) {
  const auto rocks = cairn::io::read_json(out() / "rocks.json").at("rocks");
  ASSERT_GT(rocks.size(), 0U);
  for (const auto& rock : rocks.as_array()) {
    const auto text = rock.dump(0);
    if (text.find("not_measurable") == std::string::npos) continue;
    EXPECT_THAT(text, Not(HasSubstr("\"alpha_rad\""))) << text;
  }
}

TEST_F(BrightonBeach, TheCostmapLinesUpWithTheSurface) {
  const auto surface = cairn::io::raster_info(out() / "surface.tif").geometry;
  const auto cost = cairn::io::raster_info(out() / "costmap.tif").geometry;
  const auto views = cairn::io::raster_info(out() / "views.tif").geometry;
  const double tolerance = 0.5 * cost.cell;
  EXPECT_NEAR(cost.west, surface.west, tolerance);
  EXPECT_NEAR(cost.north, surface.north, tolerance);
  EXPECT_NEAR(cost.east(), surface.east(), cost.cell);
  EXPECT_NEAR(views.west, surface.west, tolerance);
  EXPECT_NEAR(views.north, surface.north, tolerance);
}

TEST_F(BrightonBeach, OtherReadersOpenEveryProductWithoutWarning) {
  for (const auto* name : {"surface.tif", "views.tif", "costmap.tif"}) {
    const auto info = run_program("/usr/bin/gdalinfo", {(out() / name).string()});
    EXPECT_EQ(info.exit_code, 0) << name;
    EXPECT_EQ(info.err, "") << name;
    EXPECT_THAT(info.out, HasSubstr("LAYOUT=COG")) << name;
  }
  const auto layers = run_program("/usr/bin/ogrinfo", {"-ro", "-so", "-al", (out() / "layers.gpkg").string()});
  EXPECT_EQ(layers.exit_code, 0);
  EXPECT_EQ(layers.err, "");
  for (const auto* name : {"targets", "rocks", "obstacles", "frames", "footprints", "gaps"})
    EXPECT_THAT(layers.out, HasSubstr(std::string("Layer name: ") + name));
  for (const auto& entry : fs::directory_iterator(out() / "rocks")) {
    if (entry.path().extension() != ".glb") continue;
    const auto model = run_program("/usr/bin/assimp", {"info", entry.path().string()});
    EXPECT_EQ(model.exit_code, 0) << entry.path();
    EXPECT_THAT(model.out, ContainsRegex("Meshes: +1")) << entry.path();
  }
}

TEST_F(BrightonBeach, TheSecondRunDoesNothingAndSaysSo) {
  const auto before = contents(out());
  const auto again = run_job(out());
  EXPECT_EQ(again.exit_code, 0) << again.err;
  EXPECT_THAT(again.out, HasSubstr("Nothing to do"));
  EXPECT_THAT(differing(contents(out()), before), IsEmpty());
}

TEST_F(BrightonBeach, ADryRunShowsStagesMemoryAndDiskAndWritesNothing) {
  const TempFolder elsewhere;
  const auto plan = run_job(elsewhere / "planned", {"--dry-run"});
  EXPECT_EQ(plan.exit_code, 0) << plan.err;
  EXPECT_THAT(plan.out, HasSubstr("locate"));
  EXPECT_THAT(plan.out, ContainsRegex("memory up to [0-9]+ MiB, disk [0-9]+ MiB"));
  EXPECT_FALSE(fs::exists(elsewhere / "planned"));
}

TEST_F(BrightonBeach, AnotherSeedNeedsAnotherFolder) {
  EXPECT_EQ(run_job(out(), {"--seed", "7"}).exit_code, 7);
  EXPECT_EQ(run_job(out(), {"--set", "locate.mode=paper"}).exit_code, 7);
  EXPECT_EQ(run_job(out(), {"--set", "locate.nonsense=1"}).exit_code, 2);
}

TEST_F(BrightonBeach, OneAndFourThreadsGiveTheSameBytes) {
  const TempFolder elsewhere;
  const auto reference = contents(out());
  ASSERT_GT(reference.size(), 20U);
  for (const auto* threads : {"1", "4"}) {
    const auto to = elsewhere / threads;
    ASSERT_EQ(run_job(to, {"--threads", threads}).exit_code, 0);
    EXPECT_THAT(differing(contents(to), reference), IsEmpty()) << threads << " threads";
  }
}

// The program is killed when the record of a stage appears or shortly after; then the job is resumed.
TEST_F(BrightonBeach, ResumingAfterAKillGivesTheSameBytes) {
  const TempFolder elsewhere;
  const fs::path to = elsewhere / "out";
  const auto reference = contents(out());
  std::vector<std::string> texts{CAIRN_PROGRAM};
  for (const auto& argument : job(to)) texts.push_back(argument);
  const std::pair<const char*, int> moments[] = {
      {"locate", 0}, {"terrain", 40}, {"surface", 15}, {"coverage", 100}, {"layers", 5}};
  for (const auto& [stage, delay_ms] : moments) {
    const pid_t child = ::fork();
    if (child == 0) {
      std::vector<char*> argv;
      for (auto& text : texts) argv.push_back(text.data());
      argv.push_back(nullptr);
      ::close(1);
      ::close(2);
      ::execv(argv[0], argv.data());
      ::_exit(127);
    }
    const fs::path record = to / ".cairn" / (std::string(stage) + ".json");
    constexpr int kPatience = 60000;
    for (int waited = 0; waited < kPatience && !fs::exists(record); ++waited)
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    std::this_thread::sleep_for(std::chrono::milliseconds(delay_ms));
    ::kill(child, SIGKILL);
    int status = 0;
    ::waitpid(child, &status, 0);
    ASSERT_TRUE(WIFSIGNALED(status)) << "the job had ended before the kill after " << stage;
    EXPECT_FALSE(fs::exists(to / "run.json")) << stage;
  }
  const auto resumed = run_job(to);
  ASSERT_EQ(resumed.exit_code, 0) << resumed.err;
  EXPECT_THAT(resumed.out, ContainsRegex("locate +kept"));
  EXPECT_THAT(differing(contents(to), reference), IsEmpty());
}

// Flown from above, the walls of the boulders' cylinders fail; the planned re-flight brings them above 95 %.
TEST_F(BrightonBeach, TheReFlightSeesTheWallsOfTheBoulders) {
  const TempFolder folder;
  const auto plan = cairn({"plan", "gaps", out().string(), "--survey", survey().string(), "--classes", "boulder",
                           "--max-candidates", "15000", "-o", (folder / "plan").string(), "--json"});
  ASSERT_TRUE(plan.exit_code == 0 || plan.exit_code == 3) << plan.err;
  const auto summary = cairn::io::parse_json(plan.out, "stdout");
  EXPECT_GE(summary.at("targets").as_integer(), 30);
  EXPECT_LT(summary.at("walls_before").as_real(), 0.05);
  EXPECT_GE(summary.at("walls_after").as_real(), 0.95);
  EXPECT_LE(summary.at("peak_speed_m_s").as_real(), 1.0);
  EXPECT_LE(summary.at("peak_acceleration_m_s2").as_real(), 1.0);
  EXPECT_GE(summary.at("least_clearance_m").as_real(), 2.9);
}

}  // namespace
