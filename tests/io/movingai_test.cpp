#include "io/movingai.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "support/data.hpp"

namespace cairn::io {
namespace {

using ::testing::HasSubstr;
using testing::TempFolder;

class MovingAi : public ::testing::Test {
 protected:
  TempFolder folder_;
  // What reading a text says.
  template <typename Read>
  std::string said(const std::string& text, const Read& read) {
    base::write_file(folder_ / "file", text);
    try {
      read(folder_ / "file");
    } catch (const base::Error& error) {
      EXPECT_EQ(error.code(), base::ErrorCode::invalid_input);
      return error.what();
    }
    return "";
  }
  std::string map_said(const std::string& text) {
    return said(text, [](const auto& path) { return read_octile_map(path).values.size(); });
  }
  std::string scenario_said(const std::string& text) {
    return said(text, [](const auto& path) { return read_scenario(path, 2, 3).size(); });
  }
};

TEST_F(MovingAi, ReadsAMap) {
  base::write_file(folder_ / "m.map", "type octile\r\nheight 2\r\nwidth 3\r\nmap\r\n.G@\r\nTSW\r\n");
  const auto map = read_octile_map(folder_ / "m.map");
  EXPECT_EQ(map.geometry.rows, 2U);
  EXPECT_EQ(map.geometry.columns, 3U);
  EXPECT_EQ(std::string(map.values.begin(), map.values.end()), ".G@TSW");
  for (const char c : std::string(".GS")) EXPECT_TRUE(is_free_terrain(c));
  for (const char c : std::string("@OTW")) EXPECT_FALSE(is_free_terrain(c));
}

TEST_F(MovingAi, ReadsAPublishedMapAndItsScenario) {
  const auto map = read_octile_map(testing::test_data("movingai/arena.map"));
  EXPECT_EQ(map.geometry.rows, 49U);
  const auto queries = read_scenario(testing::test_data("movingai/arena.map.scen"), 49, 49);
  ASSERT_EQ(queries.size(), 160U);
  // "0 maps/dao/arena.map 49 49 1 13 4 12 3.41421": x before y
  EXPECT_EQ(queries[2].line, 4U);
  EXPECT_EQ(queries[2].start, std::pair(std::size_t{13}, std::size_t{1}));
  EXPECT_EQ(queries[2].goal, std::pair(std::size_t{12}, std::size_t{4}));
  EXPECT_EQ(queries[2].optimal, 3.41421);
}

TEST_F(MovingAi, AcceptsNamesWithBlanksAndBothVersionsOfOne) {
  EXPECT_EQ(scenario_said("version 1.0\n0\tmy map.map\t3\t2\t0\t0\t2\t1\t2.41421\n\n"), "");
  EXPECT_EQ(scenario_said("version 1\n"), "");
}

TEST_F(MovingAi, SaysWhatIsWrongWithAMap) {
  EXPECT_THAT(map_said(""), HasSubstr("header ends"));
  EXPECT_THAT(map_said("type octile\nheight 2\nmap\n...\n...\n"), HasSubstr("lacks type, height or width"));
  EXPECT_THAT(map_said("type tile\nheight 2\nwidth 3\nmap\n"), HasSubstr("not an octile map"));
  EXPECT_THAT(map_said("type octile\nheight -2\nwidth 3\nmap\n"), HasSubstr("no size"));
  EXPECT_THAT(map_said("type octile\nheight 900000\nwidth 900000\nmap\n...\n"), HasSubstr("shorter than the map"));
  EXPECT_THAT(map_said("type octile\nheight 3\nwidth 3\nmap\n...\n...\n"), HasSubstr("ends too early"));
  EXPECT_THAT(map_said("type octile\nheight 2\nwidth 3\nmap\n....\n...\n"), HasSubstr("another length"));
  EXPECT_THAT(map_said("type octile\nheight 2\nwidth 3\nmap\n...\n.?.\n"),
              HasSubstr("line 6: unknown terrain at column 2"));
  EXPECT_THAT(map_said("type octile\nheight 1\nwidth 3\nmap\n...\n...\n"), HasSubstr("after its last row"));
  EXPECT_THAT(map_said("P5\n"), HasSubstr("not a header line"));
}

TEST_F(MovingAi, SaysWhatIsWrongWithAScenario) {
  EXPECT_THAT(scenario_said(""), HasSubstr("version 1"));
  EXPECT_THAT(scenario_said("version 2\n"), HasSubstr("version 1"));
  EXPECT_THAT(scenario_said("version 1\n0 m 3 2 0 0 2 1\n"), HasSubstr("nine fields"));
  EXPECT_THAT(scenario_said("version 1\n0 m 6 4 0 0 2 1 1\n"), HasSubstr("map of another size"));
  EXPECT_THAT(scenario_said("version 1\n0 m 3 2 3 0 2 1 1\n"), HasSubstr("line 2: bad start x"));
  EXPECT_THAT(scenario_said("version 1\n0 m 3 2 0 0 2 -1 1\n"), HasSubstr("bad goal y"));
  EXPECT_THAT(scenario_said("version 1\n0 m 3 2 0 0 2 1 nan\n"), HasSubstr("bad length"));
}

}  // namespace
}  // namespace cairn::io
