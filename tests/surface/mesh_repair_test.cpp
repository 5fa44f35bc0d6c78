#include "surface/mesh_repair.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "io/obj.hpp"
#include "support/bodies.hpp"
#include "support/data.hpp"
#include "surface/mesh_checks.hpp"
#include "surface/rock_body.hpp"

namespace cairn::surface {
namespace {

using namespace cairn::testing;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr double kExact = 1e-12;

double volume(const TriangleMesh& mesh) {
  return geometry::mass_properties(mesh).volume;
}

TriangleMesh both(TriangleMesh a, const TriangleMesh& b) {
  const auto n = static_cast<std::uint32_t>(a.vertices.size());
  a.vertices.insert(a.vertices.end(), b.vertices.begin(), b.vertices.end());
  for (const auto& t : b.triangles) a.triangles.push_back({t[0] + n, t[1] + n, t[2] + n});
  return a;
}

// Every triangle with three vertices of its own.
TriangleMesh soup(const TriangleMesh& mesh) {
  TriangleMesh result;
  for (const auto& t : mesh.triangles) {
    const auto n = static_cast<std::uint32_t>(result.vertices.size());
    for (const auto v : t) result.vertices.push_back(mesh.vertices[v]);
    result.triangles.push_back({n, n + 1, n + 2});
  }
  return result;
}

std::string reason_of(const TriangleMesh& mesh) {
  const auto result = body_of(mesh);
  const auto* why = std::get_if<base::Reject>(&result);
  return why == nullptr ? "none" : why->reason;
}

TEST(MeshRepair, SoundMeshStaysAsItIs) {
  const auto mesh = block(1, 1, 3);
  const auto result = repair(mesh);
  EXPECT_THAT(result.notes, IsEmpty());
  EXPECT_EQ(result.mesh.triangles, mesh.triangles);
  EXPECT_EQ(result.closed_share, 0.0);
  EXPECT_THAT(result.base, IsEmpty());
}

TEST(MeshRepair, InsideOut) {
  const auto result = repair(geometry::flipped(block(1, 1, 3)));
  EXPECT_THAT(result.notes, ElementsAre("turned_outwards"));
  EXPECT_NEAR(volume(result.mesh), 3.0, kExact);
}

TEST(MeshRepair, SomeFacesTurned) {
  auto mesh = subdivided(block(1, 1, 3));
  for (const std::size_t t : {std::size_t{3}, std::size_t{4}, std::size_t{20}})
    std::swap(mesh.triangles[t][1], mesh.triangles[t][2]);
  const auto result = repair(mesh);
  EXPECT_THAT(result.notes, ElementsAre("faces_turned"));
  EXPECT_TRUE(geometry::topology(result.mesh).closed());
  EXPECT_NEAR(volume(result.mesh), 3.0, kExact);
}

TEST(MeshRepair, UnweldedWithDegenerateFaces) {
  auto mesh = soup(block(1, 1, 3));
  mesh.triangles.push_back({0, 0, 1});
  mesh.triangles.push_back({0, 1, 1});
  const auto result = repair(mesh);
  EXPECT_THAT(result.notes, ElementsAre("unwelded", "degenerate_triangles"));
  EXPECT_EQ(result.mesh.vertices.size(), 8U);
  EXPECT_NEAR(volume(result.mesh), 3.0, kExact);
}

TEST(MeshRepair, DuplicateFacesAndFins) {
  auto mesh = block(1, 1, 3);
  mesh.triangles.push_back(mesh.triangles.front());
  mesh.vertices.emplace_back(2, 2, 1);
  const auto& t = mesh.triangles[2];
  mesh.triangles.push_back({t[0], t[1], 8});
  const auto result = repair(mesh);
  EXPECT_THAT(result.notes, Contains("folds_removed"));
  EXPECT_TRUE(geometry::topology(result.mesh).closed());
  EXPECT_NEAR(volume(result.mesh), 3.0, kExact);
}

TEST(MeshRepair, AFaceIsMissing) {
  auto mesh = block(1, 1, 3);
  mesh.triangles.erase(mesh.triangles.begin());
  const auto result = repair(mesh);
  EXPECT_THAT(result.notes, ElementsAre("holes_closed"));
  EXPECT_THAT(result.base, IsEmpty());
  EXPECT_NEAR(volume(result.mesh), 3.0, kExact);
  EXPECT_NEAR(result.closed_share, 1.5 / 14.0, kExact);
}

TEST(MeshRepair, OpenBaseIsClosedAndDeclared) {
  auto mesh = truncated_ellipsoid(.5, .4, .6, .45, 64);
  const auto whole = volume(mesh);
  std::erase_if(mesh.triangles, [&](const Triangle& t) {
    return mesh.vertices[t[0]].z() < -.449 && mesh.vertices[t[1]].z() < -.449 && mesh.vertices[t[2]].z() < -.449;
  });
  const auto result = body_of(mesh);
  const auto& body = std::get<RockBody>(result);
  EXPECT_THAT(body.notes, Contains("base_closed"));
  EXPECT_EQ(body.cap, survey::CapModel::patch);
  EXPECT_TRUE(body.contact_assumed);
  ASSERT_EQ(body.contact.size(), 64U);
  for (const auto& v : body.contact) EXPECT_EQ(v.position.z(), -.45);
  EXPECT_TRUE(body.quality.watertight);
  EXPECT_NEAR(body.mass.volume, whole, kExact);
  EXPECT_GT(body.quality.unseen_area_fraction, 0.05);
  EXPECT_LT(body.quality.unseen_area_fraction, 0.15);
}

// The rim of an L is not star-shaped about its middle: ears.
TEST(MeshRepair, ConcaveBase) {
  const Ring ring{{0, 0}, {3, 0}, {3, 1}, {1, 1}, {1, 3}, {0, 3}};
  auto mesh = prism(ring, 1.0);
  std::erase_if(mesh.triangles, [&](const Triangle& t) {
    return mesh.vertices[t[0]].z() + mesh.vertices[t[1]].z() + mesh.vertices[t[2]].z() == 0.0;
  });
  const auto result = repair(mesh);
  EXPECT_THAT(result.notes, ElementsAre("base_closed"));
  EXPECT_TRUE(geometry::topology(result.mesh).closed());
  EXPECT_NEAR(volume(result.mesh), 5.0, kExact);
  EXPECT_FALSE(self_intersects(result.mesh));
}

TEST(MeshRepair, TwoShells) {
  EXPECT_EQ(reason_of(both(block(1, 1, 3), moved(block(1, 1, 3), {3, 0, 0}))), "several_pieces");
  const auto crumb = both(block(1, 1, 3), moved(block(1, 1, 1), {3, 0, 0}, 0.0, 0.1));
  const auto result = repair(crumb);
  EXPECT_THAT(result.notes, ElementsAre("pieces_dropped"));
  EXPECT_NEAR(volume(result.mesh), 3.0, kExact);
}

TEST(MeshRepair, ThroughItself) {
  // A cube whose top corner was pulled through the opposite side.
  auto mesh = subdivided(block(1, 1, 1));
  for (auto& v : mesh.vertices)
    if (v == Vec3(0, 0, 1)) v = Vec3(0, 0, -1);
  const auto result = body_of(mesh);
  if (const auto* body = std::get_if<RockBody>(&result)) {
    EXPECT_THAT(body->notes, Contains("self_intersecting"));
    EXPECT_FALSE(body->quality.watertight);
  }
}

TEST(MeshRepair, MoreHoleThanSurface) {
  auto mesh = block(1, 1, 3);
  mesh.triangles.resize(2);  // one side of the block
  EXPECT_NE(reason_of(mesh), "none");
  TriangleMesh none;
  none.vertices = mesh.vertices;
  EXPECT_EQ(reason_of(none), "flat_points");
  none.triangles = {{0, 1, 1}};
  EXPECT_EQ(reason_of(none), "flat_points");
  none.triangles = {{0, 1, 2}};
  EXPECT_NE(reason_of(none), "none");
}

// Rocks cut out of terrain scans, open below (tests/data/polar_rocks/LICENSE).
TEST(MeshRepair, PolarRocksAreClosedAndDeclared) {
  for (const char* name :
       {"terrain01_rock6_decimate-005.obj", "terrain01_rock1_decimate-005.obj", "terrain01_rock14_decimate-005.obj",
        "terrain01_rock15_decimate-005.obj", "terrain01_rock3.obj"}) {
    const auto result = body_of(io::read_obj_mesh(test_data("polar_rocks/" + std::string(name))).mesh);
    const auto* body = std::get_if<RockBody>(&result);
    ASSERT_NE(body, nullptr) << name << " " << std::get<base::Reject>(result).message;
    EXPECT_THAT(body->notes, Contains("base_closed")) << name;
    EXPECT_EQ(body->cap, survey::CapModel::patch);
    EXPECT_GE(body->contact.size(), 40U);
    EXPECT_TRUE(body->quality.topology.closed());
    EXPECT_GT(body->cap_height_sigma, 0.0);
    EXPECT_GT(body->quality.unseen_area_fraction, 0.1);
    EXPECT_LT(body->quality.unseen_area_fraction, 0.5);
    EXPECT_LE(body->mass.volume, body->hull_volume);
    EXPECT_GT(body->mass.volume, 0.4 * body->hull_volume) << name;
  }
}

}  // namespace
}  // namespace cairn::surface
