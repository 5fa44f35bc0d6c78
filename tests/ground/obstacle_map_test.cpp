#include "ground/obstacle_map.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "base/error.hpp"
#include "base/random.hpp"

namespace cairn::ground {
namespace {

using geometry::Mat2;
using geometry::Vec2;
using geometry::Vec3;
using survey::Packet;

constexpr std::int64_t kQuarter = 250'000'000;  // ns; paper B's 4 Hz

const geometry::Ring kField{{-20, -20}, {20, -20}, {20, 20}, {-20, 20}};

Packet packet(std::uint32_t sequence, geometry::Ring footprint = kField) {
  Packet p;
  p.sequence = sequence;
  p.capture_time_ns = 1'000'000'000 + kQuarter * static_cast<std::int64_t>(sequence);
  p.footprint = std::move(footprint);
  return p;
}
void see(Packet& p, const Vec2& at, const std::string& object_class = "cone", double sigma = 0.1, double width = 0.4) {
  p.objects.push_back({Vec3(at.x(), at.y(), 0.0), sigma * sigma * Mat2::Identity(), width, 0.7, object_class, 0.9});
}

TEST(ObstacleMap, TwoLooksConfirmAndFuse) {
  ObstacleMap map;
  auto a = packet(1);
  see(a, {5.0, 5.0});
  EXPECT_EQ(map.add(a).born, 1U);
  EXPECT_TRUE(map.obstacles(a.capture_time_ns).empty());
  EXPECT_EQ(map.obstacles(a.capture_time_ns, false).size(), 1U);
  auto b = packet(2);
  see(b, {5.2, 5.0});
  EXPECT_EQ(map.add(b).associated, 1U);
  const auto seen = map.obstacles(b.capture_time_ns);
  ASSERT_EQ(seen.size(), 1U);
  EXPECT_NEAR(seen[0].position.x(), 5.1, 1e-6);               // m; equal weights
  EXPECT_NEAR(seen[0].covariance(0, 0), 0.005 + 0.01, 1e-5);  // m^2; half the variance, and what looks share
  EXPECT_EQ(seen[0].observations, 2U);
  EXPECT_EQ(seen[0].target.value, 1);
  EXPECT_EQ(seen[0].first_seen_ns, a.capture_time_ns);
  EXPECT_EQ(seen[0].last_seen_ns, b.capture_time_ns);
  EXPECT_FALSE(seen[0].velocity);
}

// Greedy pairing would give the middle look to the left cone and leave the other two unpaired.
TEST(ObstacleMap, AssignsAsAWhole) {
  ObstacleMap map;
  auto a = packet(1);
  see(a, {0.0, 0.0});
  see(a, {0.5, 0.0});
  map.add(a);
  auto b = packet(2);
  see(b, {0.22, 0.0});
  see(b, {0.0 - 0.25, 0.0});
  const auto report = map.add(b);
  EXPECT_EQ(report.associated, 2U);
  const auto seen = map.obstacles(b.capture_time_ns);
  ASSERT_EQ(seen.size(), 2U);
  EXPECT_LT(seen[0].position.x(), 0.0);
  EXPECT_NEAR(seen[1].position.x(), 0.36, 1e-6);
}

TEST(ObstacleMap, ClearsWhatIsGoneOnlyWhereTheImageLooks) {
  ObstacleMap map;
  std::uint32_t k = 0;
  for (; k < 10; ++k) {
    auto p = packet(k);
    see(p, {5.0, 5.0});
    see(p, {5.0, -5.0});
    map.add(p);
  }
  // From here on only the southern half is looked at, and it is empty.
  const geometry::Ring south{{-20, -20}, {20, -20}, {20, 0}, {-20, 0}};
  std::size_t looks = 0;
  for (; map.obstacles(packet(k).capture_time_ns).size() == 2 && looks < 50; ++k, ++looks) map.add(packet(k, south));
  EXPECT_EQ(looks, 6U);  // (4.595 - 0.405) / 0.811, rounded up
  for (int i = 0; i < 8; ++i) map.add(packet(k++, south));
  const auto left = map.obstacles(packet(k).capture_time_ns);
  ASSERT_EQ(left.size(), 1U);
  EXPECT_NEAR(left[0].position.y(), 5.0, 1e-6);
  EXPECT_EQ(left[0].misses, 0U);
  EXPECT_EQ(map.obstacles(packet(k).capture_time_ns, false).size(), 1U);
  // Without a footprint nothing is missed.
  for (int i = 0; i < 50; ++i) map.add(packet(k++, {}));
  EXPECT_EQ(map.obstacles(packet(k).capture_time_ns).size(), 1U);
}

TEST(ObstacleMap, SurvivesAPoorDetector) {
  // Bushes: average precision 32 % in paper B's table. Every second look fails.
  ObstacleMap map;
  base::Random random(5, "obstacle_map", 0);
  std::uint32_t k = 0;
  for (int i = 0; i < 400; ++i) {
    auto p = packet(k++);
    if (random.uniform() < 0.6) see(p, {3.0 + 0.1 * random.normal(), 4.0 + 0.1 * random.normal()}, "bush", 0.15, 1.0);
    map.add(p);
  }
  const auto seen = map.obstacles(packet(k).capture_time_ns);
  ASSERT_EQ(seen.size(), 1U);
  EXPECT_EQ(seen[0].target.value, 1);  // never lost and born again
  EXPECT_LT((seen[0].position.head<2>() - Vec2(3.0, 4.0)).norm(), 0.03);
}

TEST(ObstacleMap, FalseDetectionsAreNeverConfirmed) {
  ObstacleMap map;
  base::Random random(6, "obstacle_map", 0);
  std::size_t confirmed = 0;
  std::uint32_t k = 0;
  for (int i = 0; i < 300; ++i) {
    auto p = packet(k++);
    see(p, {random.uniform(-18, 18), random.uniform(-18, 18)});
    map.add(p);
    confirmed += map.obstacles(p.capture_time_ns).size();
  }
  // Two by chance within the gate (0.7 m) while the first is remembered for about 4 looks.
  EXPECT_LT(confirmed, 60U);  // obstacle-packets of 300; a union would have 45 150
}

TEST(ObstacleMap, FollowsAMovingObject) {
  // Paper B, B17: 0.4 m/s at 4 Hz.
  ObstacleMap map;
  base::Random random(8, "obstacle_map", 0);
  std::uint32_t k = 0;
  for (; k < 40; ++k) {
    auto p = packet(k);
    see(p, {-5.0 + 0.1 * k + 0.05 * random.normal(), 2.0 + 0.05 * random.normal()}, "cone", 0.05);
    see(p, {8.0 + 0.05 * random.normal(), 2.0 + 0.05 * random.normal()}, "cone", 0.05);
    map.add(p);
  }
  const auto seen = map.obstacles(packet(k - 1).capture_time_ns);
  ASSERT_EQ(seen.size(), 2U);
  ASSERT_TRUE(seen[0].velocity);
  EXPECT_NEAR(seen[0].velocity->x(), 0.4, 0.08);  // m/s
  EXPECT_NEAR(seen[0].velocity->y(), 0.0, 0.08);
  EXPECT_NEAR(seen[0].position.x(), -5.0 + 0.1 * (k - 1), 0.1);  // m; paper B's figure for the delay alone
  EXPECT_FALSE(seen[1].velocity);
  // It stops: at rest again where it stopped.
  const double stop = -5.0 + 0.1 * (k - 1);
  for (int i = 0; i < 40; ++i) {
    auto p = packet(k++);
    see(p, {stop + 0.05 * random.normal(), 2.0 + 0.05 * random.normal()}, "cone", 0.05);
    map.add(p);
  }
  const auto rested = map.obstacles(packet(k).capture_time_ns);
  ASSERT_EQ(rested.size(), 1U);  // the other was missed for ten seconds
  EXPECT_FALSE(rested[0].velocity);
  EXPECT_NEAR(rested[0].position.x(), stop, 0.08);
}

TEST(ObstacleMap, AMovingObjectIsForgottenOutOfView) {
  ObstacleMap map;
  std::uint32_t k = 0;
  for (; k < 20; ++k) {
    auto p = packet(k);
    see(p, {0.2 * k, 0.0}, "cone", 0.05);
    map.add(p);
  }
  const std::int64_t last = packet(k - 1).capture_time_ns;
  ASSERT_EQ(map.obstacles(last).size(), 1U);
  ASSERT_TRUE(map.obstacles(last)[0].velocity);
  EXPECT_EQ(map.obstacles(last + 4'900'000'000).size(), 1U);
  EXPECT_TRUE(map.obstacles(last + 5'100'000'000).empty());
}

TEST(ObstacleMap, LatePacketsComeToTheSameMap) {
  base::Random random(9, "obstacle_map", 0);
  std::vector<Packet> packets;
  for (std::uint32_t k = 0; k < 12; ++k) {
    auto p = packet(k);
    for (const double east : {-6.0, 0.0, 6.0}) see(p, {east + 0.1 * random.normal(), 1.0 + 0.1 * random.normal()});
    packets.push_back(p);
  }
  ObstacleMap in_order, late;
  for (const auto& p : packets) in_order.add(p);
  std::swap(packets[3], packets[5]);
  std::swap(packets[8], packets[11]);
  for (const auto& p : packets) late.add(p);
  const auto a = in_order.obstacles(packet(12).capture_time_ns), b = late.obstacles(packet(12).capture_time_ns);
  ASSERT_EQ(a.size(), 3U);
  ASSERT_EQ(b.size(), 3U);
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_LT((a[i].position - b[i].position).norm(), 1e-9);
    EXPECT_EQ(a[i].observations, b[i].observations);
    EXPECT_EQ(b[i].last_seen_ns, packet(11).capture_time_ns);
  }
  EXPECT_EQ(late.add(packets[0]).rejects.at(0).reason, "duplicate_packet");
}

TEST(ObstacleMap, KeepsKindsApart) {
  ObstacleMap map;
  for (std::uint32_t k = 0; k < 3; ++k) {
    auto p = packet(k);
    see(p, {1.0, 1.0}, "tree", 0.1, 4.0);
    see(p, {1.1, 1.0}, "cone");
    p.vehicles.push_back({Vec3(1.0, 1.1, 0.0), 0.01 * Mat2::Identity()});
    map.add(p);
  }
  const auto seen = map.obstacles(packet(3).capture_time_ns);
  ASSERT_EQ(seen.size(), 3U);
  EXPECT_EQ(seen[0].kind, survey::ObstacleKind::ignored);
  EXPECT_EQ(seen[1].kind, survey::ObstacleKind::obstacle);
  EXPECT_EQ(seen[2].kind, survey::ObstacleKind::vehicle);
  EXPECT_EQ(seen[2].object_class, "ugv");
}

TEST(ObstacleMap, MergesTwoBoxesOfOneObjectButNotNeighbours) {
  ObstacleMap map;
  std::uint32_t k = 0;
  for (; k < 4; ++k) {
    auto p = packet(k);
    see(p, {0.0, 0.0}, "boulder", 0.1, 2.0);
    if (k == 1) see(p, {0.3, 0.0}, "boulder", 0.1, 2.0);
    see(p, {6.0, 0.0});
    see(p, {6.5, 0.0});
    map.add(p);
  }
  EXPECT_EQ(map.obstacles(packet(k).capture_time_ns, false).size(), 3U);
}

TEST(ObstacleMap, PaperModeIsTheUnion) {
  ObstacleMapOptions options;
  options.memory = "paper";
  ObstacleMap map(options);
  for (std::uint32_t k = 0; k < 5; ++k) {
    auto p = packet(k);
    if (k < 2) see(p, {0.0, 0.0});
    map.add(p);
  }
  EXPECT_EQ(map.obstacles(packet(1000).capture_time_ns).size(), 2U);
}

TEST(ObstacleMap, EvidenceFadesByItsHalfLife) {
  ObstacleMapOptions options;
  options.half_life_s = 10.0;
  ObstacleMap map(options);
  for (std::uint32_t k = 0; k < 8; ++k) {
    auto p = packet(k);
    see(p, {0.0, 0.0});
    map.add(p);
  }
  const std::int64_t last = packet(7).capture_time_ns;
  EXPECT_EQ(map.obstacles(last).size(), 1U);
  // ln(99) = 4.595 falls to ln(1.5) = 0.405 after 3.5 half-lives.
  EXPECT_EQ(map.obstacles(last + 34'000'000'000).size(), 1U);
  EXPECT_EQ(map.obstacles(last + 36'000'000'000).size(), 0U);
}

TEST(ObstacleMap, RefusesNumbersThatAreNone) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  ObstacleMap map;
  auto p = packet(1);
  for (int i = 0; i < 6; ++i) see(p, {0.0, static_cast<double>(i)});
  p.objects[0].covariance(0, 1) = kNaN;
  p.objects[1].position.x() = kNaN;
  p.objects[2].covariance << 1.0, 2.0, 2.0, 1.0;
  p.objects[3].size_m = std::numeric_limits<double>::infinity();
  p.objects[4].covariance.setZero();  // not sent: the unknown sigma
  p.objects[5].score = kNaN;
  p.vehicles.push_back({Vec3(kNaN, 0, 0), Mat2::Identity()});
  const auto report = map.add(p);
  std::vector<std::string> reasons;
  for (const auto& r : report.rejects) reasons.push_back(r.reason);
  EXPECT_THAT(reasons,
              ::testing::ElementsAre("bad_covariance", "bad_position", "bad_covariance", "bad_size", "bad_position"));
  const auto seen = map.obstacles(p.capture_time_ns, false);
  ASSERT_EQ(seen.size(), 2U);
  EXPECT_NEAR(seen[0].covariance(0, 0), 0.25 + 0.01, 1e-5);
  EXPECT_EQ(seen[1].score, 0.0);
  ObstacleMapOptions wrong;
  wrong.gate_sigma = kNaN;
  EXPECT_THROW(ObstacleMap{wrong}, base::Error);
}

}  // namespace
}  // namespace cairn::ground
