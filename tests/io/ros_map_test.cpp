#include "io/ros_map.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <functional>
#include <sstream>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "io/keepout.hpp"
#include "io/map_image.hpp"
#include "io/ros_map_writer.hpp"
#include "support/data.hpp"

namespace cairn::io {
namespace {

using geometry::Grid;
using ::testing::HasSubstr;

const MapGeoreference kPlace{{46.842979, -91.993612, 198.0}, survey::HeightType::ellipsoidal, "", "PROJCRS[...]"};

RosMap small_map(MapMode mode) {
  RosMap map;
  map.mode = mode;
  map.occupancy = Grid<std::uint8_t>({-12.5, 30.25, 0.25, 5, 3}, 0);
  map.occupancy.at(0, 0) = 100;
  map.occupancy.at(2, 4) = kOccupancyUnknown;
  if (mode != MapMode::trinary) map.occupancy.at(1, 2) = 37;
  return map;
}

std::string error_of(base::ErrorCode code, const std::function<void()>& act) {
  try {
    act();
  } catch (const base::Error& error) {
    EXPECT_EQ(error.code(), code) << error.what();
    return error.what();
  }
  return "no error";
}

// A second reader, written from Nav2's description of the map_server alone: what a robot would see.
struct RobotMap {
  std::size_t width = 0, height = 0;
  double resolution = 0, x = 0, y = 0, yaw = 0;
  std::vector<int> data;  // row-major from the lower left, as nav_msgs/OccupancyGrid
};

RobotMap robot_reads(const std::filesystem::path& folder, const std::string& yaml_name) {
  std::ifstream yaml(folder / yaml_name);
  std::string line, image, mode = "trinary";
  double occupied = 0, free_level = 0;
  int negate = 0;
  RobotMap map;
  while (std::getline(yaml, line)) {
    for (char& c : line)
      if (c == '[' || c == ']' || c == ',' || c == '"') c = ' ';
    std::istringstream words(line);
    std::string key;
    words >> key;
    if (key == "image:") words >> image;
    if (key == "mode:") words >> mode;
    if (key == "resolution:") words >> map.resolution;
    if (key == "origin:") words >> map.x >> map.y >> map.yaw;
    if (key == "negate:") words >> negate;
    if (key == "occupied_thresh:") words >> occupied;
    if (key == "free_thresh:") words >> free_level;
  }
  std::vector<double> grey, opacity;  // 0..1; opacity empty = the image has none
  if (image.substr(image.size() - 3) == "pgm") {
    std::ifstream pgm(folder / image, std::ios::binary);
    std::string magic;
    pgm >> magic >> std::ws;
    while (pgm.peek() == '#') {
      std::getline(pgm, line);
      pgm >> std::ws;
    }
    int maximum = 0;
    pgm >> map.width >> map.height >> maximum;
    pgm.get();
    std::vector<char> pixels(map.width * map.height);
    pgm.read(pixels.data(), static_cast<std::streamsize>(pixels.size()));
    for (const char pixel : pixels) grey.push_back(static_cast<unsigned char>(pixel) / 255.0);
  } else {
    const MapImage pixels = read_map_image(folder / image);
    map.width = pixels.columns;
    map.height = pixels.rows;
    for (const auto sum : pixels.colour) grey.push_back(sum / 3.0 / 255.0);
    for (const auto value : pixels.opacity) opacity.push_back(value / 255.0);
  }
  map.data.resize(grey.size());
  for (std::size_t y = 0; y < map.height; ++y)
    for (std::size_t x = 0; x < map.width; ++x) {
      const std::size_t i = y * map.width + x;
      const double shade = mode == "trinary" && !opacity.empty() ? (3.0 * grey[i] + opacity[i]) / 4.0 : grey[i];
      const double occ = negate != 0 ? shade : 1.0 - shade;
      int cell = -1;
      if (mode == "scale" && !opacity.empty() && opacity[i] < 1.0) {
        cell = -1;
      } else if (mode == "raw") {
        const double value = std::round(shade * 255);
        cell = value <= 100 ? static_cast<int>(value) : -1;
      } else if (occ > occupied) {
        cell = 100;
      } else if (occ < free_level) {
        cell = 0;
      } else if (mode == "scale") {
        cell = static_cast<int>(std::rint((occ - free_level) / (occupied - free_level) * 100.0));
      }
      map.data[(map.height - 1 - y) * map.width + x] = cell;
    }
  return map;
}

// Compares cell by cell, by place and not by index.
void expect_same(const RosMap& map, const RobotMap& robot) {
  constexpr double kToleranceM = 1e-9;  // rounding of origin + rows * resolution
  const auto& g = map.occupancy.geometry;
  ASSERT_EQ(robot.width, g.columns);
  ASSERT_EQ(robot.height, g.rows);
  EXPECT_EQ(robot.resolution, g.cell);
  EXPECT_EQ(robot.yaw, 0.0);
  EXPECT_NEAR(robot.x, g.west, kToleranceM);
  EXPECT_NEAR(robot.y, g.south(), kToleranceM);
  std::size_t wrong = 0;
  for (std::size_t j = 0; j < robot.height; ++j)
    for (std::size_t i = 0; i < robot.width; ++i) {
      const auto cell = g.cell_at({robot.x + (static_cast<double>(i) + 0.5) * robot.resolution,
                                   robot.y + (static_cast<double>(j) + 0.5) * robot.resolution});
      ASSERT_TRUE(cell.has_value());
      const int value = map.occupancy.at(cell->first, cell->second);
      if ((value == kOccupancyUnknown ? -1 : value) != robot.data[j * robot.width + i]) ++wrong;
    }
  EXPECT_EQ(wrong, 0U);
}

class EveryMode : public ::testing::TestWithParam<MapMode> {};

TEST_P(EveryMode, RobotAndReaderSeeWhatWasWritten) {
  const testing::TempFolder folder;
  const RosMap map = small_map(GetParam());
  write_ros_map(folder.path(), "map", map, kPlace);
  expect_same(map, robot_reads(folder.path(), "map.yaml"));
  const RosMap read = read_ros_map(folder / "map.yaml");
  EXPECT_EQ(read.mode, map.mode);
  EXPECT_EQ(read.occupancy.values, map.occupancy.values);
  EXPECT_EQ(read.occupancy.geometry, map.occupancy.geometry);
}

TEST_P(EveryMode, EveryValueSurvives) {
  const testing::TempFolder folder;
  RosMap map;
  map.mode = GetParam();
  map.occupancy = Grid<std::uint8_t>({0.0, 1.0, 1.0, 101, 1}, 0);
  for (std::size_t i = 0; i <= 100; ++i)
    map.occupancy.values[i] = static_cast<std::uint8_t>(map.mode == MapMode::trinary ? (i % 2) * 100 : i);
  write_ros_map(folder.path(), "map", map, kPlace);
  EXPECT_EQ(read_ros_map(folder / "map.yaml").occupancy.values, map.occupancy.values);
  expect_same(map, robot_reads(folder.path(), "map.yaml"));
}

INSTANTIATE_TEST_SUITE_P(RosMap, EveryMode, ::testing::Values(MapMode::trinary, MapMode::scale, MapMode::raw),
                         [](const auto& instance) { return std::string(name_of(instance.param)); });

TEST(RosMap, FilesAreAsDocumented) {
  const testing::TempFolder folder;
  write_ros_map(folder.path(), "map", small_map(MapMode::trinary), kPlace);
  EXPECT_EQ(base::read_file(folder / "map.yaml"),
            "image: map.pgm\nmode: trinary\nresolution: 0.25\norigin: [-12.5, 29.5, 0]\nnegate: 0\n"
            "occupied_thresh: 0.65\nfree_thresh: 0.1\n");
  const std::string free_cell(1, static_cast<char>(254));
  const std::string pgm = base::read_file(folder / "map.pgm");
  EXPECT_EQ(pgm.substr(0, 11), "P5\n5 3\n255\n");
  EXPECT_EQ(pgm.size(), 11U + 15U);
  EXPECT_EQ(pgm[11], '\0') << "row 0 is the top; occupied is black";
  EXPECT_EQ(static_cast<unsigned char>(pgm[12]), 254);
  EXPECT_EQ(static_cast<unsigned char>(pgm.back()), 205);
  const MapGeoreference place = read_map_georeference(folder / "map.georeference.json");
  EXPECT_EQ(place.origin, kPlace.origin);
  EXPECT_EQ(place.height_type, survey::HeightType::ellipsoidal);
  EXPECT_EQ(place.crs_wkt, kPlace.crs_wkt);
}

TEST(RosMap, ReadsMapsOfNav2) {
  for (const char* name : {"depot.yaml", "depot_speed.yaml", "tb3_sandbox.yaml"}) {
    const RosMap map = read_ros_map(testing::test_data("nav2_maps") / name);
    expect_same(map, robot_reads(testing::test_data("nav2_maps"), name));
  }
  // depot: free_thresh 0.25 turns its unknown cells (205) into free ones, as Nav2 itself does.
  const RosMap depot = read_ros_map(testing::test_data("nav2_maps/depot.yaml"));
  EXPECT_EQ(depot.occupancy.geometry.columns, 604U);
  EXPECT_EQ(depot.occupancy.at(0, 0), 0);
  // tb3_sandbox: 0.196 keeps them unknown.
  const RosMap sandbox = read_ros_map(testing::test_data("nav2_maps/tb3_sandbox.yaml"));
  EXPECT_EQ(sandbox.occupancy.at(0, 0), kOccupancyUnknown);
  EXPECT_EQ(sandbox.occupancy.geometry.west, -10.0);
  // testmap: a PNG, turned by one radian.
  EXPECT_THAT(error_of(base::ErrorCode::invalid_input,
                       [] { (void)read_ros_map(testing::test_data("nav2_maps/testmap.yaml")); }),
              HasSubstr("yaw 1"));
}

TEST(RosMap, RefusesWhatRobotsWouldMisread) {
  const testing::TempFolder folder;
  const auto refuse = [&](const std::function<void(RosMap&)>& change, const char* word, const char* name = "map") {
    RosMap map = small_map(MapMode::trinary);
    change(map);
    EXPECT_THAT(error_of(base::ErrorCode::invalid_argument, [&] { write_ros_map(folder.path(), name, map, kPlace); }),
                HasSubstr(word));
  };
  refuse([](RosMap& m) { m.free_thresh = 0.25; }, "free_thresh 0.25");
  refuse([](RosMap& m) { m.occupied_thresh = 0.1; }, "thresholds");
  refuse([](RosMap& m) { m.occupancy.at(1, 1) = 50; }, "row 1, column 1");
  refuse([](RosMap& m) { m.occupancy.geometry.cell = 0.0; }, "place");
  refuse([](RosMap& m) { m.occupancy.geometry.columns = std::size_t{1} << 40U; }, "2^31");
  refuse([](RosMap&) {}, "plain word", "../map");
  refuse([](RosMap& m) { m.yaw = 1.0; }, "yaw 1");
  refuse([](RosMap& m) { m.occupancy.values.pop_back(); }, "each cell");
  RosMap scale = small_map(MapMode::scale);
  scale.occupancy.at(0, 1) = 101;
  EXPECT_THAT(error_of(base::ErrorCode::invalid_argument, [&] { write_ros_map(folder.path(), "map", scale, kPlace); }),
              HasSubstr("row 0, column 1"));
}

TEST(RosMap, ScaleHoldsUnknownCellsAsPixelsOneCanSeeThrough) {
  const testing::TempFolder folder;
  write_ros_map(folder.path(), "map", small_map(MapMode::scale), std::nullopt);
  EXPECT_TRUE(std::filesystem::exists(folder / "map.png"));
  EXPECT_FALSE(std::filesystem::exists(folder / "map.pgm"));
  EXPECT_FALSE(std::filesystem::exists(folder / "map.georeference.json"));
  EXPECT_EQ(read_map_image(folder / "map.png").opacity.back(), 0);
}

TEST(RosMap, RowByRowGivesTheSameBytes) {
  const testing::TempFolder folder;
  const RosMap map = small_map(MapMode::raw);
  write_ros_map(folder.path(), "whole", map, kPlace);
  RosMapWriter writer(folder.path(), "rows", map, kPlace);
  for (std::size_t r = 0; r < 3; ++r) {
    EXPECT_THROW(writer.finish(), base::Error) << "rows are missing";
    writer.rows(std::span(map.occupancy.values).subspan(r * 5, 5));
  }
  writer.finish();
  EXPECT_EQ(base::read_file(folder / "rows.pgm"), base::read_file(folder / "whole.pgm"));
}

TEST(RosMap, MapsOfNav2RoundTrip) {
  for (const char* name :
       {"depot.yaml", "depot_keepout.yaml", "depot_speed.yaml", "tb3_sandbox.yaml", "testmap.yaml"}) {
    const testing::TempFolder folder;
    RosMap map = read_ros_map(testing::test_data("nav2_maps") / name, {true});
    map.yaw = 0.0;
    if (map.mode == MapMode::trinary) {
      map.free_thresh = RosMap{}.free_thresh;
      map.occupied_thresh = RosMap{}.occupied_thresh;
    }
    write_ros_map(folder.path(), "map", map, std::nullopt);
    EXPECT_EQ(read_ros_map(folder / "map.yaml").occupancy.values, map.occupancy.values) << name;
    expect_same(map, robot_reads(folder.path(), "map.yaml"));
  }
}

TEST(RosMap, ReadsPngAndBmpAsThePgmOfTheSameMap) {
  const testing::TempFolder folder;
  for (const char* name : {"testmap.pgm", "testmap.png", "testmap.bmp"})
    std::filesystem::copy(testing::test_data("nav2_maps") / name, folder / name);
  const auto read = [&](const std::string& image) {
    base::write_file(folder / "map.yaml", "image: " + image +
                                              "\nresolution: 0.1\norigin: [2, 3, 1]\nnegate: 0\n"
                                              "occupied_thresh: 0.65\nfree_thresh: 0.196\n");
    return read_ros_map(folder / "map.yaml", {true});
  };
  const RosMap pgm = read("testmap.pgm");
  EXPECT_EQ(pgm.yaw, 1.0);
  EXPECT_EQ(pgm.occupancy.geometry.columns, 10U);
  EXPECT_GT(std::count(pgm.occupancy.values.begin(), pgm.occupancy.values.end(), 100), 0);
  EXPECT_EQ(read("testmap.png").occupancy.values, pgm.occupancy.values);
  EXPECT_EQ(read("testmap.bmp").occupancy.values, pgm.occupancy.values);
  // Cut short, or with a size that its bytes cannot justify.
  const std::string png = base::read_file(folder / "testmap.png");
  for (const std::size_t size : {9U, 20U, 40U, 100U}) {
    base::write_file(folder / "cut.png", png.substr(0, size));
    EXPECT_THROW((void)read_map_image(folder / "cut.png"), base::Error) << size;
  }
  std::string huge = png;
  huge[16] = '\x7f';
  base::write_file(folder / "huge.png", huge);
  EXPECT_THAT(error_of(base::ErrorCode::invalid_input, [&] { (void)read_map_image(folder / "huge.png"); }),
              HasSubstr("fewer pixels"));
}

TEST(Keepout, ParametersNameTheMaskAndEveryNode) {
  const testing::TempFolder folder;
  write_keepout_parameters(folder / "keepout_params.yaml", "keepout.yaml");
  const std::string text = base::read_file(folder / "keepout_params.yaml");
  for (const char* word : {"yaml_filename: \"keepout.yaml\"", "filter_mask_server:", "costmap_filter_info_server:",
                           "type: 0", "nav2_costmap_2d::KeepoutFilter", "global_costmap:", "local_costmap:"})
    EXPECT_THAT(text, HasSubstr(word));
}

TEST(RosMap, RefusesHostileFiles) {
  const testing::TempFolder folder;
  base::write_file(folder / "ok.pgm", std::string("P5\n2 2\n255\n\0\0\0\0", 15));
  std::filesystem::create_directory(folder / "maps");
  base::write_file(folder / "maps/ok.pgm", std::string("P5\n2 2\n255\n\0\0\0\0", 15));
  const std::string good =
      "image: ok.pgm\nresolution: 0.1\norigin: [0, 0, 0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.1\n";
  const auto try_yaml = [&](const std::string& text, const char* word,
                            base::ErrorCode code = base::ErrorCode::invalid_input) {
    base::write_file(folder / "maps/map.yaml", text);
    EXPECT_THAT(error_of(code, [&] { (void)read_ros_map(folder / "maps/map.yaml"); }), HasSubstr(word)) << text;
  };
  const auto with = [&](const std::string& from, const std::string& to) {
    std::string text = good;
    return text.replace(text.find(from), from.size(), to);
  };
  base::write_file(folder / "maps/map.yaml", "# a comment\n---\n" + with("ok.pgm", "'ok.pgm' # here"));
  EXPECT_EQ(read_ros_map(folder / "maps/map.yaml").occupancy.values.size(), 4U);
  try_yaml(with("ok.pgm", "../ok.pgm"), "outside");
  try_yaml(with("ok.pgm", (folder / "ok.pgm").string()), "outside");
  std::filesystem::create_symlink(folder / "ok.pgm", folder / "maps/link.pgm");
  try_yaml(with("ok.pgm", "link.pgm"), "outside");
  try_yaml(with("ok.pgm", "absent.pgm"), "not there", base::ErrorCode::not_found);
  try_yaml(with("negate: 0\n", ""), "'negate'");
  try_yaml(with("negate: 0", "negate: 2"), "negate");
  try_yaml(good + "negate: 0\n", "twice");
  try_yaml(with("0.1\n", "-0.1\n"), "line 2");
  try_yaml(with("0.1\n", "nan\n"), "line 2");
  try_yaml(with("[0, 0, 0]", "[0, 0]"), "[x, y, yaw]");
  try_yaml(with("[0, 0, 0]", "[0, 0, 0, 0]"), "[x, y, yaw]");
  try_yaml(with("[0, 0, 0]", "\n  - 0\n  - 0\n  - 0"), "line 3");
  try_yaml(with("[0, 0, 0]", "[0, 0, 1.57]"), "yaw");
  try_yaml(with("0.65", "0.05"), "thresholds");
  try_yaml(good + "mode: loud\n", "loud");
  try_yaml(good + "extra: &anchor x\n", "do not need");
  try_yaml("", "'occupied_thresh'");
  try_yaml(std::string(100000, 'a'), "map.yaml");
  const auto try_pgm = [&](const std::string& bytes, const char* word) {
    base::write_file(folder / "maps/bad.pgm", bytes);
    try_yaml(with("ok.pgm", "bad.pgm"), word);
  };
  try_pgm("", "P5");
  try_pgm("P2\n1 1\n255\n0\n", "P5");
  try_pgm("P5\n2 2\n255\n\1\1\1", "fewer pixels");
  try_pgm("P5\n4000000000 4000000000\n255\nxx", "fewer pixels");
  try_pgm("P5\n99999999999999999999 1\n255\nxx", "byte");
  try_pgm("P5\n0 5\n255\n", "width");
  try_pgm("P5\n2 2\n65535\n12345678", "8 bits");
  try_pgm("P5 # never ends", "width");
}

}  // namespace
}  // namespace cairn::io
