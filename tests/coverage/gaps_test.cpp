#include "coverage/gaps.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "coverage/patch_outline.hpp"
#include "support/meshes.hpp"
#include "support/views.hpp"

namespace cairn::coverage {
namespace {

using geometry::TriangleMesh;
using geometry::Vec3;

constexpr double kArea = 1e-9;  // m^2, rounding

template <typename Predicate>
std::vector<Verdict> verdicts_where(const TriangleMesh& mesh, Verdict verdict, Predicate inside) {
  std::vector<Verdict> v(mesh.triangles.size(), Verdict::passed);
  for (std::size_t i = 0; i < v.size(); ++i)
    if (inside(mesh.centroid(i))) v[i] = verdict;
  return v;
}

TEST(Gaps, PatchesWithOutlineAreaAndHoles) {
  const TriangleMesh mesh = testing::slab(0, 0, 10, 10, 2, 10);
  const auto in = [](const Vec3& c, double a, double b, double d, double e) {
    return c.x() > a && c.x() < b && c.y() > d && c.y() < e;
  };
  // A square frame of 5 x 5 around a hole of 1 x 1, and a square of 2 x 1 far from it.
  const auto verdicts = verdicts_where(mesh, Verdict::occluded, [&](const Vec3& c) {
    return (in(c, 0, 5, 0, 5) && !in(c, 2, 3, 2, 3)) || in(c, 7, 9, 8, 9);
  });
  ViewSet views;
  views.cameras.push_back(testing::pinhole_camera(1000, 1000, 1000));
  testing::add_view(views, Vec3(9, 9, 22), Vec3(9, 9, 0));
  testing::add_view(views, Vec3(1, 1, 22), Vec3(1, 1, 0));
  GapOptions options;
  options.nearest_frames = 1;
  const auto gaps = find_gaps(mesh, verdicts, views, options);
  ASSERT_EQ(gaps.size(), 2U);
  EXPECT_EQ(gaps[0].id.value, 0);
  EXPECT_EQ(gaps[0].reason, "occluded");
  EXPECT_NEAR(gaps[0].area_m2, 24.0, kArea);
  EXPECT_EQ(gaps[0].facets, 48U);
  ASSERT_EQ(gaps[0].rings.size(), 2U);
  EXPECT_NEAR(geometry::signed_area(gaps[0].rings[0]), 25.0, kArea);
  EXPECT_EQ(gaps[0].rings[0].size(), 4U);  // straight runs are reduced to their ends
  EXPECT_NEAR(geometry::signed_area(gaps[0].rings[1]), -1.0, kArea);
  ASSERT_EQ(gaps[0].nearest_frames.size(), 1U);
  EXPECT_EQ(gaps[0].nearest_frames[0].value, 1);
  EXPECT_NEAR(gaps[1].area_m2, 2.0, kArea);
  EXPECT_EQ(gaps[1].nearest_frames[0].value, 0);
  ASSERT_TRUE(gaps[1].view.has_value());
  // Straight above the gap: the ground is level.
  EXPECT_NEAR(gaps[1].view->position.x(), gaps[1].centre.x(), kArea);
  EXPECT_GT(gaps[1].view->position.z(), 15.0);
  EXPECT_NEAR(gaps[1].centre.z(), 2.0, kArea);
}

TEST(Gaps, ReasonsAndTouchingCornersSeparate) {
  const TriangleMesh mesh = testing::slab(0, 0, 4, 4, 0, 4);
  auto verdicts = verdicts_where(mesh, Verdict::no_data, [](const Vec3& c) { return c.x() < 2 && c.y() < 2; });
  for (std::size_t i = 0; i < verdicts.size(); ++i) {
    const Vec3 c = mesh.centroid(i);
    if (c.x() > 2 && c.y() > 2) verdicts[i] = Verdict::no_data;  // touches the first in one vertex
    if (c.x() > 2 && c.y() < 2) verdicts[i] = Verdict::low_parallax;
  }
  const auto gaps = find_gaps(mesh, verdicts, {}, {});
  ASSERT_EQ(gaps.size(), 3U);
  for (const auto& gap : gaps) {
    EXPECT_NEAR(gap.area_m2, 4.0, kArea);
    ASSERT_EQ(gap.rings.size(), 1U);
    EXPECT_NEAR(geometry::signed_area(gap.rings[0]), 4.0, kArea);
    EXPECT_FALSE(gap.view.has_value());
    EXPECT_TRUE(gap.nearest_frames.empty());
  }
}

TEST(Gaps, RingsThatTouchInAVertexStayApart) {
  // Two holes that touch corner to corner.
  const TriangleMesh mesh = testing::slab(0, 0, 4, 4, 0, 4);
  const auto verdicts = verdicts_where(mesh, Verdict::occluded, [](const Vec3& c) {
    const bool first = c.x() > 1 && c.x() < 2 && c.y() > 1 && c.y() < 2;
    const bool second = c.x() > 2 && c.x() < 3 && c.y() > 2 && c.y() < 3;
    return !first && !second;
  });
  const auto gaps = find_gaps(mesh, verdicts, {}, {});
  ASSERT_EQ(gaps.size(), 1U);
  double total = 0.0;
  for (const auto& ring : gaps[0].rings) total += geometry::signed_area(ring);
  EXPECT_NEAR(total, 14.0, kArea);
}

TEST(Gaps, SmallPatchesAreLeftOut) {
  const TriangleMesh mesh = testing::slab(0, 0, 4, 4, 0, 4);
  const auto verdicts = verdicts_where(mesh, Verdict::occluded, [](const Vec3& c) { return c.x() < 1 && c.y() < 1; });
  GapOptions options;
  options.min_area_m2 = 1.1;
  EXPECT_TRUE(find_gaps(mesh, verdicts, {}, options).empty());
  options.min_area_m2 = 0.9;
  EXPECT_EQ(find_gaps(mesh, verdicts, {}, options).size(), 1U);
}

TEST(Gaps, WallsGetTheHullFromAbove) {
  const TriangleMesh mesh = testing::box(Vec3(0, 0, 0), Vec3(2, 3, 4));
  const std::vector<Verdict> verdicts(mesh.triangles.size(), Verdict::too_oblique);
  const auto gaps = find_gaps(mesh, verdicts, {}, {});
  ASSERT_EQ(gaps.size(), 1U);
  EXPECT_NEAR(gaps[0].area_m2, 52.0, kArea);
  ASSERT_EQ(gaps[0].rings.size(), 1U);
  EXPECT_NEAR(geometry::signed_area(gaps[0].rings[0]), 6.0, kArea);
}

TEST(Gaps, DegenerateFacetsBelongToNoGap) {
  TriangleMesh mesh = testing::slab(0, 0, 4, 4, 0, 4);
  mesh.triangles.push_back({0, 0, 1});
  mesh.vertices.emplace_back(std::nan(""), 0, 0);
  mesh.triangles.push_back({0, 1, static_cast<std::uint32_t>(mesh.vertices.size() - 1)});
  const std::vector<Verdict> verdicts(mesh.triangles.size(), Verdict::no_data);
  const auto gaps = find_gaps(mesh, verdicts, {}, {});
  ASSERT_EQ(gaps.size(), 1U);
  EXPECT_EQ(gaps[0].facets, 32U);
  EXPECT_NEAR(gaps[0].area_m2, 16.0, kArea);
}

}  // namespace
}  // namespace cairn::coverage
