#include "report/mesh_pack.hpp"

#include <gtest/gtest.h>

#include "geometry/triangle_mesh.hpp"
#include "support/sample_report.hpp"

namespace cairn::report {
namespace {

TEST(Clustered, a_small_mesh_is_left_alone) {
  const RockView rock = testing::sample_rock(1, {0, 0, 0}, 1, 1, survey::Grade::measured);
  EXPECT_EQ(clustered({*rock.mesh, rock.facet_seen}, 1000000).mesh.triangles, rock.mesh->triangles);
}

TEST(Clustered, a_large_mesh_keeps_its_box_and_its_flags) {
  const RockView rock = testing::sample_rock(1, {500, -300, 20}, 1, 1, survey::Grade::measured);
  const FlaggedMesh small = clustered({*rock.mesh, rock.facet_seen}, 400);
  EXPECT_LE(small.mesh.triangles.size(), 400U);
  EXPECT_GT(small.mesh.triangles.size(), 60U);
  EXPECT_EQ(small.facet_seen.size(), small.mesh.triangles.size());
  EXPECT_EQ(small.mesh.colours.size(), small.mesh.vertices.size());
  constexpr double kCell = 0.4;  // m: a cluster's mean lies inside its cell
  EXPECT_LT((small.mesh.bounds().min - rock.mesh->bounds().min).norm(), kCell);
  EXPECT_LT((small.mesh.bounds().max - rock.mesh->bounds().max).norm(), kCell);
}

TEST(PackedRock, says_where_it_topples_only_where_the_grade_allows) {
  RockView rock = testing::sample_rock(1, {0, 0, 0}, 1, 1, survey::Grade::bounded);
  EXPECT_NE(packed_rock(rock, 10000).find("topple_toward_deg"), nullptr);
  rock.rock.tipping.grade = survey::Grade::not_measurable;
  EXPECT_EQ(packed_rock(rock, 10000).find("topple_toward_deg"), nullptr);
}

TEST(PackedRock, a_rock_without_a_mesh_is_an_id_alone) {
  RockView rock = testing::sample_rock(4, {0, 0, 0}, 1, 1, survey::Grade::bounded);
  rock.mesh.reset();
  EXPECT_EQ(packed_rock(rock, 10000).dump(0), R"({"id":4})");
}

}  // namespace
}  // namespace cairn::report
