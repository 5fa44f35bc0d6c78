#include "geodesy/crs.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <thread>

#include "base/error.hpp"

namespace cairn::geodesy {
namespace {

using geometry::Geodetic;
using geometry::Vec3;
using ::testing::HasSubstr;

const Geodetic kDuluth{46.842979, -91.993612, 198.0};
const Geodetic kOakland{37.8, -122.2, 30.0};
constexpr double kUsSurveyFoot = 1200.0 / 3937.0;

std::string crs_error(const std::function<void()>& act) {
  try {
    act();
  } catch (const base::Error& error) {
    EXPECT_EQ(error.code(), base::ErrorCode::crs_mismatch);
    return error.what();
  }
  return "no error";
}

TEST(DescribeCrs, KnowsUnitsAndParts) {
  const CrsInfo utm = describe_crs("EPSG:32615");
  EXPECT_EQ(utm.name, "WGS 84 / UTM zone 15N");
  EXPECT_EQ(utm.authority_code, "EPSG:32615");
  EXPECT_FALSE(utm.geographic);
  EXPECT_FALSE(utm.has_vertical);
  EXPECT_EQ(utm.horizontal_unit_m, 1.0);

  const CrsInfo feet = describe_crs("EPSG:2227+6360");
  EXPECT_EQ(feet.authority_code, "EPSG:2227+6360");
  EXPECT_TRUE(feet.has_vertical);
  EXPECT_NEAR(feet.horizontal_unit_m, kUsSurveyFoot, 1e-15);
  EXPECT_NEAR(feet.vertical_unit_m, kUsSurveyFoot, 1e-15);

  const CrsInfo geographic = describe_crs("EPSG:4979");
  EXPECT_TRUE(geographic.geographic);
  EXPECT_TRUE(geographic.has_vertical);
  EXPECT_NEAR(geographic.horizontal_unit_m, 0.017453292519943295, 1e-15);
  EXPECT_EQ(geographic.vertical_unit_m, 1.0);

  EXPECT_FALSE(describe_crs("EPSG:4326").has_vertical);
  EXPECT_TRUE(describe_crs("EPSG:32615+5831").vertical_is_depth);  // instantaneous water level depth
}

TEST(DescribeCrs, WktKeepsTheCrs) {
  const std::string wkt = crs_wkt("EPSG:2227+6360");
  EXPECT_EQ(wkt.find('\n'), std::string::npos);
  const CrsInfo info = describe_crs(wkt);
  EXPECT_NEAR(info.vertical_unit_m, kUsSurveyFoot, 1e-15);
}

TEST(DescribeCrs, RefusesWhatIsNoCrs) {
  for (const char* text : {"", "EPSG:1", "nonsense", "EPSG:5703", "+proj=utm +zone=15", "EPSG:9807", "PROJCS[\"broken",
                           "LOCAL_CS[\"here\",UNIT[\"metre\",1]]"}) {
    const std::string message = crs_error([&] { (void)describe_crs(text); });
    EXPECT_THAT(message, HasSubstr(std::string("'") + text)) << text;
  }
}

// PROJ and GeographicLib are independent.
TEST(CrsConverter, UtmAgreesWithTheLocalFrame) {
  constexpr double kToleranceM = 1e-4;  // round trip, design figure
  const LocalFrame frame(kDuluth);
  const CrsConverter utm("EPSG:32615", frame);
  EXPECT_THAT(utm.operation(), HasSubstr("UTM zone 15N"));
  for (const Vec3& p : {Vec3(0, 0, 0), Vec3(350, -420, 12), Vec3(-9000, 9000, 80)}) {
    const Vec3 outside = utm.from_local(p);
    EXPECT_NEAR((utm.to_local(outside) - p).norm(), 0.0, kToleranceM);
  }
  // The origin itself: central meridian 93 W, so about 76.7 km east of it.
  const Vec3 origin = utm.from_local(Vec3::Zero());
  EXPECT_NEAR(origin.x(), 576720.0, 200.0);
  EXPECT_NEAR(origin.z(), kDuluth.height_m, 1e-6);
}

// On the central meridian the easting is 500000 and the northing 0.9996 times the meridian arc, which
// is 4984944.378 m from the equator to 45 degrees on WGS84.
TEST(CrsConverter, MeridianArc) {
  const LocalFrame frame({45.0, -93.0, 0.0});
  const Vec3 p = CrsConverter("EPSG:32615", frame).from_local(Vec3::Zero());
  EXPECT_NEAR(p.x(), 500000.0, 1e-6);
  EXPECT_NEAR(p.y(), 0.9996 * 4984944.378, 1e-3);
}

TEST(CrsConverter, GeographicAndGeocentric) {
  const LocalFrame frame(kDuluth);
  const Vec3 expected = frame.to_local({46.85, -91.99, 210.0});
  EXPECT_NEAR((CrsConverter("EPSG:4979", frame).to_local(Vec3(-91.99, 46.85, 210.0)) - expected).norm(), 0.0, 1e-6);
  EXPECT_NEAR((CrsConverter("EPSG:4326", frame).to_local(Vec3(-91.99, 46.85, 210.0)) - expected).norm(), 0.0, 1e-6);
  const CrsConverter geocentric("EPSG:4978", frame);
  EXPECT_NEAR(geocentric.from_local(Vec3(0, 0, 0)).norm(), 6367000.0, 1000.0);
  EXPECT_NEAR((geocentric.to_local(geocentric.from_local(Vec3(10, 20, 30))) - Vec3(10, 20, 30)).norm(), 0.0, 1e-6);
}

TEST(CrsConverter, EgmHeightsBecomeEllipsoidal) {
  const LocalFrame frame(kDuluth);
  const double undulation = geoid_undulation("egm96", kDuluth);
  const CrsConverter orthometric("EPSG:32615+5773", frame);
  EXPECT_THAT(orthometric.operation(), HasSubstr("egm96"));
  EXPECT_NEAR(orthometric.from_local(Vec3::Zero()).z(), kDuluth.height_m - undulation, 1e-3);
  const CrsConverter kept("EPSG:32615+5773", frame, {Heights::keep_datum, false});
  EXPECT_NEAR(kept.from_local(Vec3::Zero()).z(), kDuluth.height_m, 1e-6);
}

TEST(CrsConverter, MissingGridIsNamed) {
  const LocalFrame frame(kDuluth);
  const std::string message = crs_error([&] { CrsConverter("EPSG:6344+5703", frame); });
  EXPECT_THAT(message, HasSubstr("us_noaa_g2018u0.tif"));
  EXPECT_THAT(message, HasSubstr("EPSG:6344+5703"));
  // Without the geoid there is no operation left that is not ballpark: still refused.
  EXPECT_THAT(crs_error([&] {
                CrsConverter("EPSG:6344+5703", frame, {Heights::to_ellipsoid, true});
              }),
              HasSubstr("us_noaa_g2018u0.tif"));
  // With the datum kept, no grid is needed.
  const CrsConverter kept("EPSG:6344+5703", frame, {Heights::keep_datum, false});
  EXPECT_THAT(kept.operation(), HasSubstr("keep their datum"));
}

TEST(CrsConverter, CoarserOperationOnlyOnRequest) {
  const LocalFrame frame(kDuluth);
  EXPECT_THAT(crs_error([&] { CrsConverter("EPSG:26915", frame); }), HasSubstr("us_noaa_"));
  const CrsConverter coarse("EPSG:26915", frame, {Heights::to_ellipsoid, true});
  EXPECT_THAT(coarse.operation(), HasSubstr("accuracy 4 m"));
}

TEST(CrsConverter, FeetBecomeMetres) {
  const LocalFrame frame(kOakland);
  const CrsConverter feet("EPSG:2227+6360", frame, {Heights::keep_datum, true});
  const Vec3 origin = feet.from_local(Vec3::Zero());
  EXPECT_NEAR(origin.z(), kOakland.height_m / kUsSurveyFoot, 1e-6);
  // 100 US survey feet up are 30.48006 m up; 1000 east are 304.8 m, but for the grid scale (1e-4) and
  // the height (5e-6).
  EXPECT_NEAR(feet.to_local(origin + Vec3(0, 0, 100)).z(), 100 * kUsSurveyFoot, 1e-6);
  const Vec3 moved = feet.to_local(origin + Vec3(1000, 0, 0));
  EXPECT_NEAR(std::hypot(moved.x(), moved.y()), 1000 * kUsSurveyFoot, 0.05);
  // Feet below, metres above.
  const CrsConverter mixed("EPSG:2227+5703", frame, {Heights::keep_datum, true});
  EXPECT_NEAR(mixed.from_local(Vec3::Zero()).z(), kOakland.height_m, 1e-6);
}

TEST(CrsConverter, FeetWithoutVerticalUnitAreAmbiguous) {
  const LocalFrame frame(kOakland);
  const std::string message = crs_error([&] { CrsConverter("EPSG:2227", frame); });
  EXPECT_THAT(message, HasSubstr("no vertical unit"));
  EXPECT_THAT(message, HasSubstr("EPSG:2227+6360"));
}

TEST(CrsConverter, BadPointsAreRefused) {
  const LocalFrame frame(kDuluth);
  const CrsConverter utm("EPSG:32615", frame);
  EXPECT_THAT(crs_error([&] { (void)utm.to_local(Vec3(std::nan(""), 0, 0)); }), HasSubstr("not finite"));
  EXPECT_THAT(crs_error([&] { (void)utm.to_local(Vec3(1e12, 1e12, 0)); }), HasSubstr("EPSG:32615"));
  const CrsConverter degrees("EPSG:4326", frame);
  EXPECT_NE(crs_error([&] { (void)degrees.to_local(Vec3(500000, 5100000, 0)); }), "no error");
}

TEST(CrsConverter, ThreadsShareOne) {
  const LocalFrame frame(kDuluth);
  const CrsConverter utm("EPSG:32615", frame);
  const Vec3 once = utm.from_local(Vec3(1, 2, 3));
  std::vector<Vec3> seen(4);
  std::vector<std::thread> threads;
  for (std::size_t t = 0; t < seen.size(); ++t)
    threads.emplace_back([&, t] {
      for (int i = 0; i < 500; ++i) seen[t] = utm.from_local(Vec3(1, 2, 3));
    });
  for (auto& thread : threads) thread.join();
  for (const Vec3& p : seen) EXPECT_EQ(p, once);
}

// NGA's test points of the EGM96 harmonics (file OUTPUT.DAT of program F477).
TEST(Geoid, MatchesPublishedPoints) {
  constexpr double kGridErrorM = 1.0;  // 15' bilinear grid against the harmonics
  struct Point {
    double lat, lon, n;
  };
  for (const Point& p :
       {Point{38.6281550, 269.7791550 - 360.0, -31.628}, Point{-14.6212170, 305.0211140 - 360.0, -2.969},
        Point{46.8743190, 102.4487290, -43.575}, Point{-23.6174460, 133.8747120, 15.871},
        Point{38.6254730, 359.9995000 - 360.0, 50.066}, Point{-0.4667440, 0.0023000, 17.329}})
    EXPECT_NEAR(geoid_undulation("egm96", {p.lat, p.lon, 0.0}), p.n, kGridErrorM) << p.lat;
  EXPECT_NEAR(geoid_undulation("egm96", {48.21, 16.41, 0.0}), 44.71, 0.01);
  EXPECT_THAT(crs_error([] { (void)geoid_undulation("egm2020", {}); }), HasSubstr("egm96"));
  EXPECT_NE(crs_error([] { (void)geoid_undulation("egm96", {91.0, 0.0, 0.0}); }), "no error");
}

// Design, section 3: a raster in this CRS overlays the local frame to a millimetre within a kilometre.
TEST(RasterCrs, EqualsTheLocalFrame) {
  constexpr double kToleranceM = 1e-3;
  for (const Geodetic& origin : {kDuluth, Geodetic{0.0, 10.0, 0.0}, Geodetic{-43.5, 171.9, 1500.0},
                                 Geodetic{69.0, 18.0, 600.0}, Geodetic{34.6, -112.4, 1600.0}}) {
    const LocalFrame frame(origin);
    const CrsConverter raster(frame.raster_crs_wkt(), frame);
    for (int azimuth = 0; azimuth < 360; azimuth += 15)
      for (const double distance : {100.0, 1000.0}) {
        const double a = azimuth * 3.14159265358979 / 180.0;
        const Vec3 p(distance * std::sin(a), distance * std::cos(a), 0.0);
        const Vec3 q = raster.from_local(p);
        EXPECT_NEAR(q.x(), p.x(), kToleranceM) << origin.latitude_deg << " azimuth " << azimuth;
        EXPECT_NEAR(q.y(), p.y(), kToleranceM) << origin.latitude_deg << " azimuth " << azimuth;
      }
  }
}

}  // namespace
}  // namespace cairn::geodesy
