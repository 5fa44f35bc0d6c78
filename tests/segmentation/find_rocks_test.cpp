#include "segmentation/find_rocks.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/random.hpp"
#include "segmentation/roughness.hpp"
#include "segmentation/touching.hpp"

namespace cairn::segmentation {
namespace {

using geometry::Vec2;
using geometry::Vec3;

constexpr double kNoise = 0.006;  // m, of the points along the normal

// A plain of 12 m with things on it, 3 cm apart.
class Field {
 public:
  explicit Field(std::uint64_t seed) : random_(seed, "find_rocks_test", 0) {}

  void dome(const Vec2& centre, double radius, double height) {
    domes_.push_back({centre, radius, height});
    const auto count = static_cast<std::size_t>(2.0 * std::numbers::pi * radius * std::max(radius, height) / 9e-4);
    for (std::size_t i = 0; i < count; ++i) {
      const double z = random_.uniform(), a = random_.uniform(0.0, 2.0 * std::numbers::pi);
      const double r = std::sqrt(1.0 - z * z);
      const double grow = 1.0 + kNoise / radius * random_.normal();
      add(Vec3(centre.x() + grow * radius * r * std::cos(a), centre.y() + grow * radius * r * std::sin(a),
               grow * height * z));
    }
  }

  void shrub(const Vec2& centre, double radius) {
    domes_.push_back({centre, radius, radius});
    const auto count = static_cast<std::size_t>(2.0 * std::numbers::pi * radius * radius / 9e-4);
    for (std::size_t i = 0; i < count; ++i) {
      Vec3 p(random_.normal(), random_.normal(), std::abs(random_.normal()));
      p *= radius * std::cbrt(random_.uniform()) / p.norm();
      points_.push_back(Vec3(centre.x(), centre.y(), 0.0) + p);
    }
  }

  std::vector<Vec3> points() {
    for (double x = -6.0; x < 6.0; x += 0.03)
      for (double y = -6.0; y < 6.0; y += 0.03) {
        const Vec2 p(x + random_.uniform(0.0, 0.02), y + random_.uniform(0.0, 0.02));
        bool free = true;
        for (const auto& d : domes_) free = free && (p - d.centre).norm() > d.radius;
        if (free) points_.emplace_back(p.x(), p.y(), kNoise * random_.normal());
      }
    return points_;
  }

 private:
  struct Dome {
    Vec2 centre;
    double radius, height;
  };
  // What lies inside another dome is not seen.
  void add(const Vec3& p) {
    for (std::size_t i = 0; i + 1 < domes_.size(); ++i) {
      const Vec2 d = (p.head<2>() - domes_[i].centre) / domes_[i].radius;
      if (d.squaredNorm() + std::pow(p.z() / domes_[i].height, 2) < 0.98) return;
    }
    points_.push_back(p);
  }

  base::Random random_;
  std::vector<Dome> domes_;
  std::vector<Vec3> points_;
};

std::vector<Candidate> found_in(const std::vector<Vec3>& points) {
  base::RunContext ctx;
  return find_rocks(points, filter_ground(points, {}, ctx), PlanIndex(points), {});
}

TEST(FindRocks, TouchingOnesArePartedAndShrubsLeftOut) {
  Field field(3);
  field.dome({-2.0, 0.0}, 0.9, 1.1);
  field.dome({-0.6, 0.0}, 0.7, 0.8);  // touches the first
  field.dome({3.0, 2.0}, 0.8, 1.0);
  field.shrub({3.0, -2.5}, 0.6);
  const auto points = field.points();
  const auto rocks = found_in(points);
  ASSERT_EQ(rocks.size(), 3U);
  constexpr double kPlace = 0.3;  // m: a cell of the ground around belongs to each; the valley between to either
  const Vec2 wanted[] = {{-2.0, 0.0}, {-0.6, 0.0}, {3.0, 2.0}};
  for (const Vec2& at : wanted) {
    int near = 0;
    for (const auto& rock : rocks) near += (rock.centre - at).norm() < kPlace;
    EXPECT_EQ(near, 1) << at.transpose();
  }
  // Nothing is lost or doubled.
  base::RunContext ctx;
  const auto ground = filter_ground(points, {}, ctx);
  for (const Candidate& object : find_candidates(points, ground, {})) {
    std::vector<std::uint32_t> all;
    for (const Candidate& part : part_touching(object, points, ground, {}))
      all.insert(all.end(), part.points.begin(), part.points.end());
    std::sort(all.begin(), all.end());
    EXPECT_EQ(all, object.points);
  }
}

TEST(FindRocks, OneRockStaysOne) {
  Field field(5);
  field.dome({0.0, 0.0}, 1.2, 0.9);
  const auto rocks = found_in(field.points());
  ASSERT_EQ(rocks.size(), 1U);
  EXPECT_NEAR(rocks[0].height, 0.9, 0.05);
  EXPECT_NEAR(rocks[0].radius, 1.3, 0.12);  // with some of the cells beside it
}

TEST(Roughness, CurvatureDoesNotCountNoiseDoes) {
  constexpr double kReach = 0.15, kWithin = 0.15;  // m; of the noise, for some 70 points a place
  for (const double noise : {0.003, 0.012}) {
    base::Random random(8, "roughness_test", 0);
    std::vector<Vec3> ball;
    for (int i = 0; i < 12'000; ++i) {
      const Vec3 n = Vec3(random.normal(), random.normal(), random.normal()).normalized();
      ball.push_back((1.0 + noise * random.normal()) * n);
    }
    const std::vector<Vec3> places(ball.begin(), ball.begin() + 200);
    EXPECT_NEAR(residual_quantile(skin_residuals(places, ball, kReach), 0.5), noise, kWithin * noise);
  }
}

TEST(Roughness, TooFewPointsAreNotJudged) {
  const std::vector<Vec3> few = {{0, 0, 0}, {0.01, 0, 0}, {0, 0.01, 0}};
  EXPECT_TRUE(std::isnan(skin_residuals(few, few, 1.0).front()));
  EXPECT_EQ(residual_quantile(skin_residuals(few, few, 1.0), 0.5), 0.0);
}

}  // namespace
}  // namespace cairn::segmentation
