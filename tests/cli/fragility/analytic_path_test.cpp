// The bodies of fragility.md section 6 and the published meshes of section 4, from mesh file and contact.csv to the
// JSON.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "base/angle.hpp"
#include "base/atomic_file.hpp"
#include "base/number_text.hpp"
#include "io/json.hpp"
#include "io/ply.hpp"
#include "support/bodies.hpp"
#include "support/data.hpp"
#include "support/run_program.hpp"

namespace {

using cairn::testing::cairn;
using namespace ::cairn::testing;
using ::cairn::io::Json;

constexpr double kGravity = 9.80665;  // m/s^2
constexpr double kPolyhedra = 1e-8;   // relative, the reference suite's own

// Mesh and contact ring through the command; the row of the rock. No ring: the base is assumed.
Json run(const TriangleMesh& mesh, const std::vector<Vec3>& ring, std::vector<std::string> more = {}) {
  const TempFolder folder;
  const std::string ply = (folder / "body.ply").string(), csv = (folder / "contact.csv").string();
  ::cairn::io::write_ply(ply, mesh);
  std::string text = "# crs: local\nrock_id,pad_id,order,x,y,z,status,sigma_m,closed\n";
  for (std::size_t i = 0; i < ring.size(); ++i) {
    text += "0,0," + std::to_string(i);
    for (int k = 0; k < 3; ++k) text += "," + ::cairn::base::to_text(ring[i][k]);
    text += ",observed,,1\n";
  }
  ::cairn::base::write_file(csv, text);
  std::vector<std::string> arguments = {"fragility", ply, "-o", (folder / "out").string(), "--json", "--draws", "0"};
  if (!ring.empty()) arguments.insert(arguments.end(), {"--contact", csv});
  arguments.insert(arguments.end(), more.begin(), more.end());
  const auto result = cairn(arguments);
  EXPECT_EQ(result.exit_code, 0) << result.err;
  return ::cairn::io::parse_json(result.out, "stdout").at("rocks").as_array().at(0);
}

double real(const Json& row, std::string_view key) {
  return row.at(key).as_real();
}
void expect_relative(double found, double expected, double tolerance, const char* what) {
  EXPECT_NEAR(found / expected, 1.0, tolerance) << what;
}

std::vector<Vec3> rectangle(double w, double d, double z = 0.0) {
  return {{-w / 2, -d / 2, z}, {w / 2, -d / 2, z}, {w / 2, d / 2, z}, {-w / 2, d / 2, z}};
}
std::vector<Vec3> circle(int n, double a, double b, double z) {
  std::vector<Vec3> ring;
  for (const auto& p : regular_polygon(n, 1.0)) ring.emplace_back(a * p.x(), b * p.y(), z);
  return ring;
}

// d: plumb line to edge, h: centre of mass above it, i_cm: per mass.
void expect_edge(const Json& row, double d, double h, double i_cm, double tolerance) {
  const double r = std::hypot(d, h), alpha = std::atan2(d, h), i = i_cm + r * r, p = std::sqrt(kGravity * r / i);
  expect_relative(real(row, "alpha_min_deg"), ::cairn::base::rad_to_deg(alpha), tolerance, "alpha");
  expect_relative(real(row, "r_m"), r, tolerance, "r");
  expect_relative(real(row, "p_rad_s"), p, tolerance, "p");
  expect_relative(real(row, "a_qs_g"), d / h, tolerance, "a_qs");
  expect_relative(real(row, "v_min_m_s"), 2 * kGravity / p * std::sin(alpha / 2) / std::cos(alpha), tolerance, "v_min");
  expect_relative(real(row, "barrier_j"), real(row, "mass_kg") * kGravity * r * (1 - std::cos(alpha)), 100 * tolerance,
                  "barrier");  // 1 - cos loses two digits in the reference
}

TEST(AnalyticPath, Blocks) {
  for (const auto& [w, d, h] : {std::array{1., 1., 3.}, {1., 2., 3.}, {.5, .5, 1.5}}) {
    const auto row = run(block(w, d, h), rectangle(w, d));
    expect_relative(real(row, "volume_m3"), w * d * h, kPolyhedra, "volume");
    expect_edge(row, w / 2, h / 2, (w * w + h * h) / 12, kPolyhedra);
    // The base of a block is what its band of lowest points gives, too.
    const auto assumed = run(block(w, d, h), {});
    expect_edge(assumed, w / 2, h / 2, (w * w + h * h) / 12, kPolyhedra);
    EXPECT_TRUE(assumed.at("alpha_interval_deg").as_array().at(0).is_null());
  }
}

TEST(AnalyticPath, OffsetShearedAndLShaped) {
  // Sheared: same volume, centre of mass moved by half the shear.
  const auto sheared = run(prism({{-.5, -1}, {.5, -1}, {.5, 1}, {-.5, 1}}, 3, {0.4, 0}), rectangle(1, 2));
  expect_relative(real(sheared, "volume_m3"), 6.0, kPolyhedra, "volume");
  EXPECT_NEAR(sheared.at("com_m").as_vec3().x(), 0.2, 1e-12);
  expect_relative(std::tan(::cairn::base::deg_to_rad(real(sheared, "alpha_min_deg"))), 0.3 / 1.5, kPolyhedra, "alpha");
  EXPECT_NEAR(real(sheared, "azimuth_deg"), 90.0, 1e-9);
  // L of two boxes: 2 x 1 and 1 x 1 in plan, 3 high; ring star-shaped about its re-entrant corner.
  const auto l = run(prism({{1, 1}, {1, 2}, {0, 2}, {0, 0}, {2, 0}, {2, 1}}, 3),
                     {{0, 0, 0}, {2, 0, 0}, {2, 1, 0}, {1, 1, 0}, {1, 2, 0}, {0, 2, 0}});
  expect_relative(real(l, "volume_m3"), 9.0, kPolyhedra, "volume");
  const double c = (2 * 1.0 + 1 * 0.5) / 3;  // centroid from the lower left, both ways
  EXPECT_NEAR(l.at("com_m").as_vec3().x(), c, 1e-12);
  // Nearest sides: the two long ones, c away. Pushed to the north-east it tips about the diagonal from (2, 1) to (1,
  // 2), which is a side of the hull only.
  expect_relative(std::tan(::cairn::base::deg_to_rad(real(l, "alpha_min_deg"))), c / 1.5, kPolyhedra, "alpha");
  const double diagonal = 3 / std::sqrt(2.0) - c * std::sqrt(2.0);
  expect_relative(l.at("a_qs_g_by_azimuth").as_array().at(45).as_real(), diagonal / 1.5, kPolyhedra, "diagonal");
}

struct Curved {
  const char* name;
  double volume, d, h, i_cm;
  TriangleMesh (*mesh)(int);
  std::vector<Vec3> (*ring)(int);
};

// Faceted bodies: the error falls fourfold when the facets halve.
TEST(AnalyticPath, CurvedBodiesConvergeToSecondOrder) {
  const std::vector<Curved> bodies = {
      {"cylinder", 2.35619449, .5, 1.5, .8125, [](int n) { return frustum(.5, .5, 3, n); },
       [](int n) { return circle(n, .5, .5, 0); }},
      {"frustum", 2.03156325, .3, 1.28350515, .37073307, [](int n) { return frustum(.3, .8, 2, n); },
       [](int n) { return circle(n, .3, .3, 0); }},
      {"cone", .52359878, .5, .5, .1875, [](int n) { return frustum(.5, 0, 2, n); },
       [](int n) { return circle(n, .5, .5, 0); }},
      {"sphere", 4.07150408, .6, .825, .387375, [](int n) { return truncated_ellipsoid(1, 1, 1, .8, n); },
       [](int n) { return circle(n, .6, .6, -.8); }},
      {"hemisphere", 2.09439510, 1, .375, .259375, [](int n) { return truncated_ellipsoid(1, 1, 1, 0, n); },
       [](int n) { return circle(n, 1, 1, 0); }},
      {"ellipsoid", 3.84845100, .52915026, .945, .385175, [](int n) { return truncated_ellipsoid(1, .8, 1.2, .9, n); },
       [](int n) { return circle(n, .66143783, .52915026, -.9); }}};
  for (const auto& body : bodies) {
    std::array<double, 2> volume{}, alpha{}, p{};
    for (std::size_t k = 0; k < 2; ++k) {
      const int n = k == 0 ? 48 : 96;
      const auto row = run(body.mesh(n), body.ring(n));
      const double r = std::hypot(body.d, body.h);
      volume[k] = std::abs(real(row, "volume_m3") / body.volume - 1);
      alpha[k] = std::abs(::cairn::base::deg_to_rad(real(row, "alpha_min_deg")) / std::atan2(body.d, body.h) - 1);
      p[k] = std::abs(real(row, "p_rad_s") / std::sqrt(kGravity * r / (body.i_cm + r * r)) - 1);
    }
    constexpr double kFinest = 2.5e-3;  // relative, 96 facets around: (pi/96)^2 times a factor of shape
    for (const auto& error : {volume, alpha, p}) {
      EXPECT_LT(error[1], kFinest) << body.name;
      EXPECT_LT(error[1], 0.3 * error[0] + 1e-8) << body.name;  // a quarter, with room for the next order
    }
  }
}

// Section 6.4: the block stands on a slope of 10 deg, +x downslope.
TEST(AnalyticPath, BlockOnASlope) {
  const double beta = ::cairn::base::deg_to_rad(10.0);
  const auto turn = [beta](const Vec3& v) {
    return Vec3(std::cos(beta) * v.x() + std::sin(beta) * v.z(), v.y(),
                -std::sin(beta) * v.x() + std::cos(beta) * v.z());
  };
  auto mesh = block(1, 1, 3);
  for (auto& v : mesh.vertices) v = turn(v);
  auto ring = rectangle(1, 1);
  for (auto& q : ring) q = turn(q);
  const auto row = run(mesh, ring);
  constexpr double kEightDigits = 5.1e-9;
  const auto& table = row.at("a_qs_g_by_azimuth").as_array();
  EXPECT_NEAR(table.at(90).as_real(), .14829048, kEightDigits);
  EXPECT_NEAR(table.at(45).as_real(), .20971441, kEightDigits);
  EXPECT_NEAR(table.at(0).as_real(), .32826925, kEightDigits);
  EXPECT_NEAR(table.at(315).as_real(), .49276543, kEightDigits);
  EXPECT_NEAR(table.at(270).as_real(), .54148654, kEightDigits);
  EXPECT_NEAR(real(row, "contact_slope_deg"), 10.0, 1e-9);
  EXPECT_NEAR(real(row, "contact_aspect_deg"), 90.0, 1e-9);
}

TEST(AnalyticPath, Invariances) {
  const auto mesh = prism({{-.5, -.8}, {.6, -.7}, {.7, .5}, {-.4, .9}}, 2.2, {0.1, -0.05});
  const std::vector<Vec3> ring(mesh.vertices.begin(), mesh.vertices.begin() + 4);
  const auto plain = run(mesh, ring);
  const Vec3 utm(500000.0, 3.8e6, 1500.0);
  auto far_ring = ring;
  for (auto& q : far_ring) q += utm;
  const auto far = run(moved(mesh, utm), far_ring);
  const auto flipped = run(::cairn::geometry::flipped(mesh), ring);
  const auto fine = run(subdivided(mesh), ring);
  const auto dense = run(mesh, ring, {"--density", "5200"});
  auto feet_ring = ring;
  for (auto& q : feet_ring) q *= 0.3048;
  const auto feet = run(moved(mesh, Vec3::Zero(), 0.0, 0.3048), feet_ring);
  for (const auto* key : {"alpha_min_deg", "r_m", "p_rad_s", "a_qs_g", "v_min_m_s"}) {
    expect_relative(real(far, key), real(plain, key), 1e-9, key);
    expect_relative(real(flipped, key), real(plain, key), 1e-12, key);
    expect_relative(real(fine, key), real(plain, key), 1e-12, key);
    EXPECT_EQ(real(dense, key), real(plain, key)) << key;
  }
  expect_relative(real(dense, "mass_kg"), 2 * real(plain, "mass_kg"), 1e-15, "mass");
  const double s = 0.3048;
  expect_relative(real(feet, "alpha_min_deg"), real(plain, "alpha_min_deg"), 1e-12, "alpha");
  expect_relative(real(feet, "r_m"), s * real(plain, "r_m"), 1e-12, "r");
  expect_relative(real(feet, "p_rad_s"), real(plain, "p_rad_s") / std::sqrt(s), 1e-12, "p");
  expect_relative(real(feet, "v_min_m_s"), real(plain, "v_min_m_s") * std::sqrt(s), 1e-12, "v_min");
  expect_relative(real(feet, "mass_kg"), s * s * s * real(plain, "mass_kg"), 1e-12, "mass");
}

Json run_published(const char* name, std::vector<std::string> more = {}) {
  const TempFolder folder;
  std::vector<std::string> arguments = {"fragility", test_data(std::string("pbr_meshes/") + name).string(),
                                        "-o",        (folder / "out").string(),
                                        "--json",    "--draws",
                                        "0"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  const auto result = cairn(arguments);
  EXPECT_EQ(result.exit_code, 0) << result.err;
  return ::cairn::io::parse_json(result.out, "stdout").at("rocks").as_array().at(0);
}

// Section 5.3: the tool's alpha was 180 deg minus the *largest* angle, its height the axis of least variance.
TEST(PeerDefects, BlockHasTheFragileAngleAndItsHeight) {
  const auto row = run_published("merge_block_Final.obj");
  EXPECT_NEAR(real(row, "alpha_min_deg"), 18.434949, 1e-4);  // coordinates of six decimals
  EXPECT_LT(real(row, "alpha_min_deg"), 90.0);
  EXPECT_NEAR(real(row.at("ratios"), "hwr_principal"), 3.0, 1e-6);
  EXPECT_NEAR(real(row, "volume_m3"), 0.375, 1e-6);
  EXPECT_GT(row.at("contact").size(), 3U);
  EXPECT_EQ(row.at("a_qs_g_by_azimuth").size(), 360U);
}

// Section 4.2: inertia of one density printed with a mass of another (6.3 % low), without 1/V (8 times too small), of
// another body. Whatever the density, inertia over mass is that of the body.
TEST(PeerDefects, InertiaGoesWithTheMassPrinted) {
  constexpr double kVolume = .1225086807, kXx = .00741022358, kYy = .00643820312, kZz = .00548172868;
  for (const double density : {2700.0, 2881.4, 1000.0}) {
    const auto row = run_published("final_sp1.obj", {"--density", ::cairn::base::to_text(density)});
    const auto& inertia = row.at("inertia_kg_m2").as_array();
    const double mass = real(row, "mass_kg");
    expect_relative(mass, density * kVolume, 1e-9, "mass");
    expect_relative(inertia.at(0).as_array().at(0).as_real() / mass, kXx / kVolume, 1e-8, "xx");
    expect_relative(inertia.at(1).as_array().at(1).as_real() / mass, kYy / kVolume, 1e-8, "yy");
    expect_relative(inertia.at(2).as_array().at(2).as_real() / mass, kZz / kVolume, 1e-8, "zz");
  }
  // The published pair fails that test: 353.00 kg with the inertia of 330.77 kg.
  const double published = (11.032465 + 17.604068 + 23.554887) / 353.0, truth = (kXx + kYy + kZz) / kVolume;
  EXPECT_NEAR(published / truth, 330.77 / 353.0, 1e-4);
}

TEST(PeerDefects, DoubleRockToItsPublishedDigits) {
  const auto row = run_published("closed_pbr.obj", {"--density", "2600"});
  EXPECT_NEAR(real(row, "mass_kg"), 1437.596, 5.1e-4);
  const auto& inertia = row.at("inertia_kg_m2").as_array();
  EXPECT_NEAR(inertia.at(0).as_array().at(0).as_real(), 260.473, 5.1e-4);
  EXPECT_NEAR(inertia.at(0).as_array().at(2).as_real(), -83.689, 5.1e-4);
  EXPECT_NEAR(inertia.at(2).as_array().at(2).as_real(), 134.045, 5.1e-4);
}

// Inward winding (section 4.2): turned, said, and measured all the same.
TEST(PeerDefects, InwardMeshIsTurned) {
  const auto row = run_published("SP1.obj");
  EXPECT_NEAR(real(row, "volume_m3"), .1238595646, 1e-8);
}

}  // namespace
