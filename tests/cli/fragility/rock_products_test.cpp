#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/atomic_file.hpp"
#include "io/json.hpp"
#include "io/mesh.hpp"
#include "io/ply.hpp"
#include "io/robot_description.hpp"
#include "support/bodies.hpp"
#include "support/data.hpp"
#include "support/run_program.hpp"

namespace {

namespace fs = std::filesystem;
using cairn::testing::cairn;
using cairn::testing::TempFolder;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

// A block of 0.5 x 1 x 1.5 m by its mesh alone: everything that follows the tipping in one run, twice.
TEST(FragilityProducts, FiguresCheckAndModels) {
  const TempFolder folder;
  const std::string mesh = (folder / "block.ply").string();
  ::cairn::io::write_ply(mesh, ::cairn::testing::block(0.5, 1.0, 1.5));
  for (const char* out : {"a", "b"}) {
    const auto result = cairn({"fragility", mesh, "--draws", "50", "--figures", "--check-3d", "--robot-models",
                               "--contact-friction", "2", "--pulse-ratios-s", "0.1", "--pulse-levels", "1.2,4",
                               "--step-halvings", "0", "-o", (folder / out).string(), "--json"});
    ASSERT_EQ(result.exit_code, 0) << result.err;
    const auto summary = ::cairn::io::parse_json(result.out, "stdout");
    EXPECT_EQ(summary.at("figures").at("sections").as_integer(), 1);
    EXPECT_EQ(summary.at("dynamics").as_array().at(0).at("runs").as_integer(), 2);
    EXPECT_EQ(summary.at("robot_models").as_array().at(0).as_string(), "models/block/model.sdf");
  }
  for (const char* name : {"block_sections.svg", "block_views.svg", "uncertainty.csv", "block_dynamics.json",
                           "block_dynamics.svg", "models/block/model.sdf", "models/block/mesh.obj"})
    EXPECT_EQ(::cairn::base::read_file(folder / "a" / name), ::cairn::base::read_file(folder / "b" / name)) << name;
  const auto description = ::cairn::io::read_robot_description(folder / "a/models/block/model.urdf");
  EXPECT_THAT(::cairn::io::link_findings(description.links.at(0),
                                         ::cairn::io::read_mesh(folder / "a/models/block/mesh.obj").mesh),
              IsEmpty());
  EXPECT_NEAR(description.links.at(0).mass_kg, 2600.0 * 0.75, 1e-6);
}

TEST(FragilityProducts, SaysWhatIsWrong) {
  const TempFolder folder;
  const std::string mesh = (folder / "block.ply").string(), out = (folder / "out").string();
  ::cairn::io::write_ply(mesh, ::cairn::testing::block(0.5, 1.0, 1.5));
  const auto run = [&](std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), {"fragility", mesh, "--draws", "20", "-o", out});
    return cairn(arguments);
  };
  const auto list = run({"--check-3d", "--pulse-levels", "1,two"});
  EXPECT_EQ(list.exit_code, 2);
  EXPECT_THAT(list.err, HasSubstr("pulse-levels"));
  EXPECT_EQ(run({"--check-3d", "--time-step-s", "0"}).exit_code, 2);
  EXPECT_EQ(run({"--survey", folder.path().string()}).exit_code, 4);  // no survey.json there
  EXPECT_FALSE(fs::exists(out));
}

}  // namespace
