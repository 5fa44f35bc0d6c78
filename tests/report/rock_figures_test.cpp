#include "report/rock_figures.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "base/angle.hpp"
#include "base/error.hpp"
#include "geometry/mass_properties.hpp"
#include "report/outcome_plane.hpp"
#include "report/rock_view.hpp"
#include "support/bodies.hpp"

namespace cairn::report {
namespace {

using geometry::Vec2;
using geometry::Vec3;
using ::testing::HasSubstr;
using ::testing::Not;

const std::vector<Vec3> kSquare = {{-0.5, -0.5, 0}, {0.5, -0.5, 0}, {0.5, 0.5, 0}, {-0.5, 0.5, 0}};

survey::Rock block_rock(const geometry::TriangleMesh& mesh) {
  survey::Rock rock;
  rock.object_class = "rock";
  rock.mass = geometry::mass_properties(mesh);
  rock.tipping.grade = survey::Grade::bounded;
  rock.tipping.contact = kSquare;
  rock.tipping.critical = survey::TippingEdge{};
  rock.tipping.critical->azimuth_deg = 90.0;
  rock.tipping.critical->alpha_rad = std::atan(1.0 / 3.0);
  return rock;
}

TEST(RockingPair, OfASquareAlongItsSidesAndItsDiagonal) {
  RockingPair pair;
  ASSERT_TRUE(rocking_pair(kSquare, {0, 0, 1.5}, 90.0, pair));
  EXPECT_NEAR(pair.towards.alpha_rad, std::atan2(0.5, 1.5), 1e-12);
  EXPECT_NEAR(pair.towards.s_m, 0.5, 1e-12);
  EXPECT_NEAR(pair.against.s_m, -0.5, 1e-12);
  EXPECT_NEAR(pair.towards.r_m, std::hypot(0.5, 1.5), 1e-12);
  ASSERT_TRUE(rocking_pair(kSquare, {0, 0, 1.5}, 30.0, pair));
  EXPECT_NEAR(pair.towards.s_m, 0.5 / std::cos(base::deg_to_rad(30.0)), 1e-12);
  // Centre moved towards east: 0.2 m left on that side.
  ASSERT_TRUE(rocking_pair(kSquare, {0.3, 0, 1.5}, 90.0, pair));
  EXPECT_NEAR(pair.towards.s_m, 0.2, 1e-12);
  EXPECT_NEAR(pair.against.s_m, -0.8, 1e-12);
  EXPECT_FALSE(rocking_pair(kSquare, {0.7, 0, 1.5}, 90.0, pair));
}

double area_of(const std::vector<Vec2>& ring) {
  double sum = 0.0;
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const Vec2 &a = ring[i], &b = ring[(i + 1) % ring.size()];
    sum += a.x() * b.y() - b.x() * a.y();
  }
  return std::abs(sum) / 2.0;
}

TEST(VerticalSection, IsOneClosedOutlineOfTheRightArea) {
  const auto block = cairn::testing::subdivided(cairn::testing::block(1, 2, 3));
  auto rings = vertical_section(block, {0.1, 0.05, 0}, 90.0);
  ASSERT_EQ(rings.size(), 1U);
  EXPECT_NEAR(area_of(rings[0]), 3.0, 1e-9);  // 1 wide, 3 high
  rings = vertical_section(block, {0.1, 0.05, 0}, 0.0);
  ASSERT_EQ(rings.size(), 1U);
  EXPECT_NEAR(area_of(rings[0]), 6.0, 1e-9);
  EXPECT_TRUE(vertical_section(block, {0, 5, 0}, 90.0).empty());
}

// Two towers make two outlines.
TEST(VerticalSection, KeepsSeparatePieces) {
  auto mesh = cairn::testing::block(1, 1, 1);
  const auto other = cairn::testing::moved(cairn::testing::block(1, 1, 2), Vec3(3, 0, 0));
  const auto offset = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), other.vertices.begin(), other.vertices.end());
  for (const auto& t : other.triangles) mesh.triangles.push_back({t[0] + offset, t[1] + offset, t[2] + offset});
  EXPECT_EQ(vertical_section(mesh, {0, 0.1, 0}, 90.0).size(), 2U);
}

TEST(ShadedView, CoversTheSilhouetteAndNothingElse) {
  const auto mesh = cairn::testing::moved(cairn::testing::block(1, 2, 3), Vec3(500000, 3.8e6, 100));
  const auto east = shaded_view(mesh, SideView(90.0), 300);  // looking east: 2 m wide
  EXPECT_EQ(east.image.height, 300U);
  EXPECT_NEAR(static_cast<double>(east.image.width), 200.0, 1.0);
  for (const auto& p : east.image.pixels) EXPECT_EQ(p[3], 255);
  // The nearer face hides the farther one: one tone only.
  const auto first = east.image.pixels[10 * east.image.width + 10],
             last = east.image.pixels[290 * east.image.width + 150];
  EXPECT_EQ(first, last);
  const auto cone = shaded_view(cairn::testing::frustum(1.0, 0.0, 2.0, 64), SideView(0.0), 200);
  std::size_t covered = 0;
  for (const auto& p : cone.image.pixels) covered += p[3] == 255 ? 1U : 0U;
  const double share = static_cast<double>(covered) / static_cast<double>(cone.image.pixels.size());
  EXPECT_NEAR(share, 0.5, 0.01);  // a triangle in its box
}

TEST(RockFigures, SayWhatTheyShow) {
  const auto mesh = cairn::testing::block(1, 1, 3);
  const auto rock = block_rock(mesh);
  const auto sections = sections_svg(rock, mesh, "rock <7> & co");
  EXPECT_THAT(sections, HasSubstr("rock &lt;7&gt; &amp; co"));
  EXPECT_THAT(sections, HasSubstr("18.4\u00b0, R 1.58 m"));
  EXPECT_THAT(sections, HasSubstr("right = 90\u00b0 from north"));
  EXPECT_THAT(sections, HasSubstr("grade bounded"));
  const auto views = side_views_svg(rock, mesh, "rock 7", 100);
  EXPECT_THAT(views, HasSubstr("looking towards 0\u00b0"));
  EXPECT_THAT(views, HasSubstr("data:image/png;base64,"));
  EXPECT_EQ(views, side_views_svg(rock, mesh, "rock 7", 100));
  for (const auto* text : {&sections, &views}) {
    EXPECT_THAT(*text, Not(HasSubstr("nan")));
    EXPECT_THAT(*text, Not(HasSubstr("inf")));
  }
  auto none = rock;
  none.tipping.critical.reset();
  EXPECT_THROW((void)sections_svg(none, mesh, ""), base::Error);
  EXPECT_THROW((void)side_views_svg(none, mesh, ""), base::Error);
}

TEST(RockFigures, TableOfWhatDominates) {
  auto rock = block_rock(cairn::testing::block(1, 1, 3));
  EXPECT_EQ(uncertainty_svg(rock, "rock"), "");
  survey::TippingUncertainty u;
  u.draws = 1000;
  u.standing = 990;
  u.variance_shares = {{"mesh", 0.05}, {"contact", 0.80}};
  u.inputs = {{"contact_sigma_m", 0.02}};
  u.scalars = {{"alpha_min_deg", {17.0, 17.5, 18.4, 19.0, 20.0}}};
  rock.tipping.uncertainty = u;
  const auto svg = uncertainty_svg(rock, "rock");
  EXPECT_THAT(svg, HasSubstr("80.0 %"));
  EXPECT_LT(svg.find("contact</text>"), svg.find("mesh</text>"));  // the largest first
  EXPECT_THAT(svg, HasSubstr("contact_sigma_m = 0.02"));
  EXPECT_THAT(svg, HasSubstr("median 18.4"));
  EXPECT_THAT(svg, HasSubstr("990 of 1000 draws stand"));
}

TEST(PhotoSvg, DrawsTheLineByWhatIsKnownOfIt) {
  const auto svg =
      photo_svg("jpeg bytes", 200, 200, {{{{10, 20}, {30, 40}}, true, false}, {{{1, 1}}, true, true}}, "photo");
  EXPECT_THAT(svg, HasSubstr("M10.0,48.0 L30.0,68.0"));  // below the heading
  EXPECT_THAT(svg, HasSubstr("stroke-dasharray"));
  EXPECT_THAT(svg, HasSubstr("data:image/jpeg;base64,"));
  EXPECT_THAT(svg, Not(HasSubstr("M1.0,29.0")));  // a single point is no line
}

TEST(OutcomePlane, MarksOutcomesAndDisagreement) {
  const std::vector<PlaneMark> marks = {{0.4, 0.1, false, false}, {0.8, 0.1, true, false}, {0.9, 0.2, true, {}}};
  const auto svg = outcome_plane_svg(marks, 0.33, "rock <7>");
  EXPECT_THAT(svg, HasSubstr("rock &lt;7&gt;"));
  EXPECT_THAT(svg, HasSubstr("quasi-static 0.330 g"));
  std::size_t crosses = 0;
  for (std::size_t at = svg.find("stroke=\"#222\" stroke-width=\"1.5\""); at != std::string::npos;
       at = svg.find("stroke=\"#222\" stroke-width=\"1.5\"", at + 1))
    ++crosses;
  EXPECT_EQ(crosses, 2U);  // one mark and the legend
}

}  // namespace
}  // namespace cairn::report
