#include "io/camera_table.hpp"

#include <gtest/gtest.h>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "support/data.hpp"

namespace cairn::io {
namespace {

const std::string kRow = "1 2 30  0 -1 0  -1 0 0  0 0 -1  3000 3001 2000 1500 4000 3000";

class CameraTable : public ::testing::Test {
 protected:
  testing::TempFolder folder_;
  std::vector<TableView> read(const std::string& text) {
    base::write_file(folder_ / "cams.txt", text);
    return read_camera_table(folder_ / "cams.txt");
  }
  std::string refusal(const std::string& text) {
    try {
      (void)read(text);
    } catch (const base::Error& e) {
      EXPECT_EQ(e.code(), base::ErrorCode::invalid_input);
      return e.record();
    }
    return "accepted";
  }
};

TEST_F(CameraTable, ReadsRowsCommentsAndBlankLines) {
  const auto views = read("# two cameras\n" + kRow + "\n\n\t" + kRow + "\r\n");
  ASSERT_EQ(views.size(), 2U);
  const TableView& v = views[1];
  EXPECT_EQ(v.T_world_camera.translation, geometry::Vec3(1, 2, 30));
  // The table's rows are the camera's axes in the world.
  EXPECT_EQ(geometry::Vec3(v.T_world_camera.rotation.col(0)), geometry::Vec3(0, -1, 0));
  EXPECT_EQ(geometry::Vec3(v.T_world_camera.rotation.col(2)), geometry::Vec3(0, 0, -1));
  EXPECT_EQ(v.camera.fx_px, 3000);
  EXPECT_EQ(v.camera.fy_px, 3001);
  EXPECT_EQ(v.camera.cx_px, 2000);
  EXPECT_EQ(v.camera.cy_px, 1500);
  EXPECT_EQ(v.camera.width_px, 4000);
  EXPECT_EQ(v.camera.height_px, 3000);
  EXPECT_TRUE(read("").empty());
}

TEST_F(CameraTable, RefusesWithTheLine) {
  EXPECT_EQ(refusal(kRow + "\n1 2 3\n"), "line 2");
  EXPECT_EQ(refusal(kRow + " 5\n"), "line 1");
  EXPECT_EQ(refusal("x" + kRow), "line 1");
  EXPECT_EQ(refusal("nan 2 30  0 -1 0  -1 0 0  0 0 -1  3000 3000 2000 1500 4000 3000"), "line 1");
  EXPECT_EQ(refusal("1 2 30  0 -1 0  -1 0 0  0 0 -1.1  3000 3000 2000 1500 4000 3000"), "line 1");
  EXPECT_EQ(refusal("1 2 30  0 1 0  -1 0 0  0 0 -1  3000 3000 2000 1500 4000 3000"), "line 1");  // a mirror
  EXPECT_EQ(refusal("1 2 30  0 -1 0  -1 0 0  0 0 -1  0 3000 2000 1500 4000 3000"), "line 1");
  EXPECT_EQ(refusal("1 2 30  0 -1 0  -1 0 0  0 0 -1  3000 3000 2000 1500 4000.5 3000"), "line 1");
  EXPECT_THROW(read_camera_table(folder_ / "none.txt"), base::Error);
}

}  // namespace
}  // namespace cairn::io
