#include "fragility/hull_section.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "base/angle.hpp"
#include "base/random.hpp"
#include "fragility/rocking_profile.hpp"

namespace cairn::fragility {
namespace {

using geometry::Vec2;
using geometry::Vec3;

std::vector<Vec3> box(double w, double d, double h, int cuts = 1) {
  std::vector<Vec3> points;
  for (int i = 0; i <= cuts; ++i)
    for (int j = 0; j <= cuts; ++j)
      for (const double z : {-0.5, 0.5})
        points.emplace_back(w * (static_cast<double>(i) / cuts - 0.5), d * (static_cast<double>(j) / cuts - 0.5),
                            h * z);
  return points;
}

geometry::MassProperties box_mass(double w, double d, double h) {
  geometry::MassProperties m;
  m.volume = w * d * h;
  m.inertia_per_density = (m.volume / 12.0 * Vec3(d * d + h * h, w * w + h * h, w * w + d * d)).asDiagonal();
  return m;
}

TEST(RestingPose, BoxRestsOnItsBase) {
  for (const int cuts : {1, 4}) {
    const auto pose = resting_pose(box(1, 2, 3, cuts), Vec3::Zero());
    ASSERT_TRUE(pose);
    EXPECT_NEAR(pose->tilt, 0.0, 1e-12);
    EXPECT_EQ(pose->rolls, 0);
  }
}

// A box held up on its edge falls onto the face that its centre leans over.
TEST(RestingPose, RollsOntoTheStableFace) {
  auto points = box(1, 1, 3);
  const auto turn = Eigen::AngleAxisd(base::deg_to_rad(25.0), Vec3::UnitY()).toRotationMatrix();
  for (auto& p : points) p = turn * p;
  const auto pose = resting_pose(points, Vec3::Zero());
  ASSERT_TRUE(pose);
  // alpha of the box is 18.4 deg: leaning by 25 deg it falls on its side, 65 deg further.
  EXPECT_NEAR(base::rad_to_deg(pose->tilt), 65.0, 1e-9);
  double lowest = 0.0;
  for (const auto& p : points) lowest = std::min(lowest, (pose->turn * p).z());
  EXPECT_NEAR(lowest, -0.5, 1e-12);
}

// Brute force: the facet is a facet of the hull, and the centre's foot lies in it.
TEST(RestingPose, RandomBodiesRestOnAFacetOfTheirHull) {
  for (std::uint64_t k = 0; k < 100; ++k) {
    base::Random random(9, "bodies", k);
    std::vector<Vec3> points;
    for (int i = 0; i < 60; ++i)
      points.push_back(
          Vec3(random.normal(), random.normal(), random.normal()).normalized().cwiseProduct(Vec3(1, 0.8, 1.3)));
    const auto pose = resting_pose(points, Vec3::Zero());
    ASSERT_TRUE(pose) << k;
    double height = 0.0;
    for (const auto i : pose->facet) height = (pose->turn * points[i]).z();
    Vec2 corner[3];
    for (std::size_t i = 0; i < 3; ++i) corner[i] = (pose->turn * points[pose->facet[i]]).head<2>();
    for (const auto& p : points) EXPECT_GE((pose->turn * p).z(), height - 1e-9) << k;
    double sign = 0.0;
    for (int i = 0; i < 3; ++i) {
      const Vec2 a = corner[i], b = corner[(i + 1) % 3];
      const double s = (b - a).x() * -a.y() - (b - a).y() * -a.x();
      EXPECT_GE(s * (sign == 0.0 ? s : sign), -1e-12) << k;
      sign = s;
    }
  }
}

TEST(RestingPose, FlatAndTinySetsHaveNone) {
  EXPECT_FALSE(resting_pose(std::vector<Vec3>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, Vec3::Zero()));
  EXPECT_FALSE(resting_pose(box(1, 1, 1), Vec3(0, 0, -5)));
}

TEST(LowerSection, OfABoxAtAnAngle) {
  const auto points = box(1, 2, 3);
  const auto pose = resting_pose(points, Vec3::Zero());
  ASSERT_TRUE(pose);
  const double a = base::deg_to_rad(20.0);
  const auto chain = lower_section(points, pose->facet, Vec3::Zero(), Vec2(std::cos(a), std::sin(a)));
  ASSERT_EQ(chain.size(), 2U);
  EXPECT_NEAR(chain[0].x(), -0.5 / std::cos(a), 1e-12);
  EXPECT_NEAR(chain[1].x(), 0.5 / std::cos(a), 1e-12);
  EXPECT_NEAR(chain[1].y(), -1.5, 1e-12);
}

// Every corner lies on the hull: no point of the body lies below the line through two corners... of the section plane,
// and heights agree with the support function of the section found by brute force over edges of all facets.
TEST(LowerSection, OfRandomBodiesIsConvexAndBelowAllChords) {
  for (std::uint64_t k = 0; k < 50; ++k) {
    base::Random random(10, "sections", k);
    std::vector<Vec3> points;
    for (int i = 0; i < 40; ++i) points.push_back(Vec3(random.normal(), random.normal(), random.normal()).normalized());
    const auto pose = resting_pose(points, Vec3::Zero());
    ASSERT_TRUE(pose);
    for (auto& p : points) p = pose->turn * p;
    const auto chain = lower_section(points, pose->facet, Vec3::Zero(), Vec2(1, 0));
    ASSERT_GE(chain.size(), 3U);
    for (std::size_t i = 0; i + 2 < chain.size(); ++i) {
      const Vec2 u = chain[i + 1] - chain[i], v = chain[i + 2] - chain[i + 1];
      EXPECT_GT(u.x() * v.y() - u.y() * v.x(), 0.0);
    }
    // Chords between any two points on either side of the plane y = 0 cross it on or above the chain.
    double lowest_gap = 1.0;
    for (const auto& p : points)
      for (const auto& q : points) {
        if (!(p.y() < 0.0) || !(q.y() >= 0.0)) continue;
        const Vec3 c = p + p.y() / (p.y() - q.y()) * (q - p);
        for (std::size_t i = 0; i + 1 < chain.size(); ++i)
          if (c.x() >= chain[i].x() && c.x() <= chain[i + 1].x()) {
            const double t = (c.x() - chain[i].x()) / (chain[i + 1].x() - chain[i].x());
            lowest_gap = std::min(lowest_gap, c.z() - (chain[i].y() + t * (chain[i + 1].y() - chain[i].y())));
          }
      }
    EXPECT_NEAR(lowest_gap, 0.0, 1e-9) << k;  // on it, and never below
  }
}

TEST(HullProfile, BoxIsHousnersRectangle) {
  const auto profile = hull_profile(box(1, 1, 3, 3), box_mass(1, 1, 3), 90.0);
  ASSERT_TRUE(profile);
  const auto expected = rectangle_profile(0.5, 1.5);
  ASSERT_EQ(profile->toes.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_NEAR(profile->toes[i].alpha, expected.toes[i].alpha, 1e-12);
    EXPECT_NEAR(profile->toes[i].p_squared, expected.toes[i].p_squared, 1e-12);
  }
  EXPECT_NEAR(profile->toes[0].eta_from_up, 0.85, 1e-12);
}

// A prism of many sides rolls: its toppling angle is that of the circle's... the highest potential, and its
// first uplift that of its narrow facet.
TEST(HullProfile, PolygonHasAToeACorner) {
  const int n = 24;
  std::vector<Vec3> points;
  for (int i = 0; i < n; ++i) {
    const double a = 2.0 * std::numbers::pi * (i + 0.5) / n;
    for (const double y : {-1.0, 1.0}) points.emplace_back(std::sin(a), y, -std::cos(a));
  }
  auto mass = box_mass(1, 2, 1);
  mass.centre_of_mass = Vec3(0, 0, -0.3);  // below the middle: the body rights itself
  const auto profile = hull_profile(points, mass, 90.0);
  ASSERT_TRUE(profile);
  EXPECT_EQ(profile->toes.size(), 12U);  // corners of the lower half
  // The centre of mass is lowest at rest and rises all the way to the side: no toppling before 90 degrees.
  EXPECT_GT(toppling_angles(*profile).up, base::deg_to_rad(80.0));
}

}  // namespace
}  // namespace cairn::fragility
