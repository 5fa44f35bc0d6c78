#include "segmentation/ground_filter.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <set>

#include "base/error.hpp"
#include "base/parallel.hpp"
#include "io/pcd.hpp"
#include "segmentation/candidates.hpp"
#include "support/boulder_field.hpp"
#include "support/data.hpp"

namespace cairn::segmentation {
namespace {

using geometry::Vec2;
using geometry::Vec3;

GroundFilterResult filtered(const std::vector<Vec3>& points, const GroundFilterOptions& options = {}) {
  base::RunContext ctx;
  return filter_ground(points, options, ctx);
}

double boulder_iou(const testing::BoulderField& field, const GroundFilterResult& result) {
  double both = 0, either = 0;
  for (std::size_t i = 0; i < field.points.size(); ++i) {
    const bool truth = field.boulder[i] >= 0, found = result.classes[i] == PointClass::above;
    both += truth && found;
    either += truth || found;
  }
  return both / either;
}

TEST(GroundFilter, FindsBouldersOnRoughSlopes) {
  // 250 points a square metre; the goal of the benchmark at four times that is 0.90.
  constexpr double kLeastIou = 0.90;
  for (const std::uint64_t seed : {1U, 2U}) {
    const auto field = testing::boulder_field(seed, 400'000, 40.0, 40);
    const auto result = filtered(field.points);
    EXPECT_GT(boulder_iou(field, result), kLeastIou) << seed;
    EXPECT_EQ(result.ground + result.above + result.below, field.points.size());
    // The bare ground below the boulders, too: median over their centres.
    constexpr double kGroundError = 0.05;  // m; the ground bends below a boulder of up to 2.4 m unseen
    std::vector<double> errors;
    for (const auto& b : field.boulders)
      errors.push_back(std::abs(result.surface.up(b.centre) - field.ground(b.centre.x(), b.centre.y())));
    std::nth_element(errors.begin(), errors.begin() + 20, errors.end());
    EXPECT_LT(errors[20], kGroundError);
  }
}

TEST(GroundFilter, HoldsAmongCrowdedBoulders) {
  const auto field = testing::boulder_field(3, 200'000, 25.0, 90, 0.2);
  const auto truth = static_cast<double>(
      std::count_if(field.boulder.begin(), field.boulder.end(), [](std::int32_t b) { return b >= 0; }));
  EXPECT_GT(truth / static_cast<double>(field.points.size()), 0.12);
  EXPECT_GT(boulder_iou(field, filtered(field.points)), 0.88);
}

struct Scores {
  double total, kappa;
};

// Errors as in Sithole & Vosselman 2004; truth by the file of ground points.
Scores isprs(const std::string& name, const GroundFilterOptions& options) {
  const auto folder = testing::test_data("isprs_filter_test");
  const auto points = io::read_pcd(folder / (name + "-utm.pcd")).cloud.positions;
  std::multiset<std::array<double, 3>> ground;
  for (const Vec3& p : io::read_pcd(folder / (name + "-utm-ground.pcd")).cloud.positions)
    ground.insert({p.x(), p.y(), p.z()});
  const auto result = filtered(points, options);
  double n[2][2] = {{0, 0}, {0, 0}};
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto at = ground.find({points[i].x(), points[i].y(), points[i].z()});
    const bool truth = at == ground.end();
    if (!truth) ground.erase(at);
    n[truth ? 1 : 0][result.classes[i] != PointClass::ground ? 1 : 0] += 1;
  }
  const double all = n[0][0] + n[0][1] + n[1][0] + n[1][1], agree = (n[0][0] + n[1][1]) / all;
  const double chance =
      ((n[0][0] + n[0][1]) * (n[0][0] + n[1][0]) + (n[1][0] + n[1][1]) * (n[0][1] + n[1][1])) / (all * all);
  return {1.0 - agree, (agree - chance) / (1.0 - chance)};
}

TEST(GroundFilter, IsprsSamplesWithOneParameterSet) {
  GroundFilterOptions airborne;
  airborne.max_object_m = 36.0;
  airborne.tolerance_m = 0.4;
  struct Limit {
    const char* name;
    double total, kappa;
  };
  // What is reached plus half a percent.
  for (const Limit& limit :
       {Limit{"samp21", 0.018, 0.955}, Limit{"samp31", 0.04, 0.925}, Limit{"samp51", 0.034, 0.905}}) {
    const Scores s = isprs(limit.name, airborne);
    EXPECT_LT(s.total, limit.total) << limit.name;
    EXPECT_GT(s.kappa, limit.kappa) << limit.name;
  }
}

TEST(GroundFilter, DependsNeitherOnThreadsNorOnTheOrderOfPoints) {
  const auto field = testing::boulder_field(4, 60'000, 20.0, 12);
  const auto result = filtered(field.points);
  {
    const base::ThreadLimit one(1);
    EXPECT_EQ(filtered(field.points).classes, result.classes);
  }
  std::vector<Vec3> reversed(field.points.rbegin(), field.points.rend());
  const auto back = filtered(reversed);
  std::size_t different = 0;
  for (std::size_t i = 0; i < reversed.size(); ++i)
    different += back.classes[i] != result.classes[reversed.size() - 1 - i];
  // Sums of heights differ in their last bit with the order.
  EXPECT_LE(different, 1U);
}

TEST(GroundFilter, MovesWithTheCloud) {
  const auto field = testing::boulder_field(5, 40'000, 20.0, 12);
  const auto result = filtered(field.points);
  std::vector<Vec3> moved = field.points;
  for (Vec3& p : moved) p += Vec3(-150.0, 300.0, 64.0);  // whole cells of 0.15 m
  const auto there = filtered(moved);
  std::size_t different = 0;
  for (std::size_t i = 0; i < moved.size(); ++i) different += there.classes[i] != result.classes[i];
  EXPECT_LT(different, moved.size() / 500);  // points on the border of cells, heights rounded to floats
}

TEST(GroundFilter, LeavesStrayPointsOutOfTheGround) {
  auto field = testing::boulder_field(6, 60'000, 20.0, 5);
  const std::size_t plain = field.points.size();
  for (int i = 0; i < 20; ++i) field.points.emplace_back(1.0 + 0.9 * i, 10.0, field.ground(1.0 + 0.9 * i, 10.0) - 3.0);
  field.points.emplace_back(std::nan(""), 3.0, 3.0);
  field.points.emplace_back(3.0, 3.0, std::numeric_limits<double>::infinity());
  const auto result = filtered(field.points);
  EXPECT_EQ(result.not_finite, 2U);
  for (std::size_t i = plain; i < plain + 20; ++i) EXPECT_EQ(result.classes[i], PointClass::below);
  for (const float z : result.surface.height.values) EXPECT_TRUE(std::isfinite(z));
  field.points.resize(plain);
  EXPECT_GT(boulder_iou(field, result), 0.85);
}

TEST(GroundFilter, BadInput) {
  EXPECT_THROW((void)filtered({}), base::Error);
  EXPECT_THROW((void)filtered({Vec3(0, 0, std::nan(""))}), base::Error);
  GroundFilterOptions fine;
  fine.cell_m = 0.1;
  EXPECT_THROW((void)filtered({Vec3(0, 0, 0), Vec3(1e7, 1e7, 0)}, fine), base::Error);
  // Two points, duplicates, a plane: ground.
  for (const auto& points : {std::vector<Vec3>{Vec3(0, 0, 0), Vec3(1, 1, 0)}, std::vector<Vec3>(5, Vec3(1, 2, 3))}) {
    const auto result = filtered(points);
    EXPECT_EQ(result.ground, points.size());
    EXPECT_TRUE(find_candidates(points, result, {}).empty());
  }
  GroundFilterOptions wrong;
  wrong.object_slope = -1.0;
  EXPECT_THROW((void)filtered({Vec3(0, 0, 0)}, wrong), base::Error);
}

}  // namespace
}  // namespace cairn::segmentation
