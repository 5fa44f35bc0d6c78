#include "pipeline/terrain_height.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "base/error.hpp"
#include "geodesy/crs.hpp"
#include "io/raster.hpp"
#include "support/data.hpp"

namespace cairn::pipeline {
namespace {

using geometry::Grid;
using geometry::Vec3;

const geometry::Geodetic kOrigin{33.8, -111.9, 700.0};
constexpr const char* kUtm = "EPSG:32612";
// A transverse Mercator as the local frame's, but another one.
constexpr const char* kOtherMercator =
    "+proj=tmerc +lat_0=31 +lon_0=-111.9166666666667 +k=0.9999 +x_0=213360 +y_0=0 +datum=WGS84 +units=m +type=crs";

double ground(double east, double north) {
  return 3.0 + 0.05 * east - 0.02 * north;
}

class TerrainHeightTest : public ::testing::Test {
 protected:
  // A slope in the given CRS, whose grid north may be turned against the local one; one cell is not known.
  std::filesystem::path raster(const std::string& crs) const {
    const geodesy::CrsConverter converter(crs.empty() ? kUtm : crs, frame_);
    const Vec3 middle = converter.from_local(Vec3::Zero());
    geometry::GridGeometry g;
    g.cell = 0.5, g.columns = g.rows = 120;
    g.west = std::round(middle.x()) - 30.0, g.north = std::round(middle.y()) + 30.0;
    Grid<float> heights(g, 0.0F);
    for (std::size_t r = 0; r < g.rows; ++r)
      for (std::size_t c = 0; c < g.columns; ++c) {
        const auto at = g.centre(r, c);
        const Vec3 local = converter.to_local(Vec3(at.x(), at.y(), kOrigin.height_m));
        heights.at(r, c) =
            static_cast<float>(frame_.to_geodetic(Vec3(local.x(), local.y(), ground(local.x(), local.y()))).height_m);
      }
    heights.at(60, 60) = std::numeric_limits<float>::quiet_NaN();
    io::write_cog(folder_ / "dsm.tif", {{"elevation", "m", "made", heights, {}}}, crs);
    return folder_ / "dsm.tif";
  }

  geodesy::LocalFrame frame_{kOrigin};
  testing::TempFolder folder_;
};

TEST_F(TerrainHeightTest, AnyCrsIsTaken) {
  for (const std::string& crs : {std::string(kUtm), geodesy::crs_wkt(kOtherMercator), frame_.raster_crs_wkt()}) {
    SCOPED_TRACE(crs);
    const TerrainHeight terrain(raster(crs), frame_);
    // Floats of 700 m in the file, and bilinear between cells of a plane.
    constexpr double kFloat = 2e-4;  // m
    for (const auto& [e, n] : {std::pair(10.3, -4.1), {-21.7, 13.2}, {0.4, 17.9}}) {
      const auto up = terrain.up(e, n);
      ASSERT_TRUE(up);
      // The value of the cell that holds the place.
      EXPECT_NEAR(*up, ground(e, n), 0.07 * 0.5 + kFloat);
    }
    const auto depth = terrain.depth(Vec3(5.0, 5.0, 30.0), Vec3(0.0, 0.0, -1.0));
    ASSERT_TRUE(depth);
    EXPECT_NEAR(*depth, 30.0 - ground(5.0, 5.0), 0.07 * 0.5 + kFloat);
    EXPECT_FALSE(terrain.up(80.0, 0.0));
  }
}

TEST_F(TerrainHeightTest, WithoutACrsItIsRefused) {
  try {
    const TerrainHeight terrain(raster(""), frame_);
    FAIL() << "taken";
  } catch (const base::Error& error) {
    EXPECT_EQ(error.code(), base::ErrorCode::crs_mismatch);
    EXPECT_NE(error.file().find("dsm.tif"), std::string::npos);
  }
}

}  // namespace
}  // namespace cairn::pipeline
