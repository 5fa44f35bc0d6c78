#include "geodesy/local_frame.hpp"

#include <gtest/gtest.h>

#include "base/error.hpp"
#include "base/random.hpp"

namespace cairn::geodesy {
namespace {

constexpr double kRoundTrip_m = 1e-8;  // what the header promises

TEST(LocalFrame, OriginIsZeroAndAxesPointEastNorthUp) {
  const LocalFrame frame({46.8426, -91.9940, 158.0});
  EXPECT_LT(frame.to_local({46.8426, -91.9940, 158.0}).norm(), kRoundTrip_m);
  EXPECT_GT(frame.to_local({46.8426, -91.9930, 158.0}).x(), 70.0);
  EXPECT_GT(frame.to_local({46.8436, -91.9940, 158.0}).y(), 100.0);
  EXPECT_NEAR(frame.to_local({46.8426, -91.9940, 159.0}).z(), 1.0, kRoundTrip_m);
}

TEST(LocalFrame, RoundTrips) {
  const LocalFrame frame({-43.5, 172.6, 20.0});
  base::Random random(1, "local_frame", 0);
  for (int i = 0; i < 200; ++i) {
    const geometry::Vec3 p(random.uniform(-9000, 9000), random.uniform(-9000, 9000), random.uniform(-100, 500));
    EXPECT_LT((frame.to_local(frame.to_geodetic(p)) - p).norm(), kRoundTrip_m);
  }
}

// Published with the Brighton Beach survey: object B02 in both frames.
TEST(LocalFrame, AgreesWithAPublishedPosition) {
  const LocalFrame frame({46.8426, -91.9940, 158.0});
  const auto g = frame.to_geodetic({30.413, 7.887, 2.979});
  constexpr double kPublishedRounding_deg = 1e-8;
  EXPECT_NEAR(g.latitude_deg, 46.84267094, kPublishedRounding_deg);
  EXPECT_NEAR(g.longitude_deg, -91.99360130, kPublishedRounding_deg);
  EXPECT_NEAR(g.height_m, 160.980, 1e-3);
}

TEST(LocalFrame, RefusesImpossibleOrigins) {
  for (const auto& bad : {geometry::Geodetic{91, 0, 0}, geometry::Geodetic{-91.994, 186.0, 0},
                          geometry::Geodetic{std::nan(""), 0, 0}, geometry::Geodetic{0, 0, 1e9}}) {
    try {
      const LocalFrame frame(bad);
      FAIL() << bad.latitude_deg;
    } catch (const base::Error& e) {
      EXPECT_EQ(e.code(), base::ErrorCode::crs_mismatch);
    }
  }
}

}  // namespace
}  // namespace cairn::geodesy
