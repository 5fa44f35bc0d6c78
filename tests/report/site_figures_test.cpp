#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "report/site_figures.hpp"
#include "support/bodies.hpp"

namespace cairn::report {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

SiteRock rock(const std::string& label, survey::Grade grade, std::optional<double> alpha) {
  SiteRock r;
  r.label = label;
  r.grade = grade;
  r.alpha_deg = alpha;
  if (alpha) r.toward_deg = 90.0;
  r.height_m = 1.0;
  return r;
}

std::size_t count(const std::string& text, const std::string& piece) {
  std::size_t n = 0;
  for (auto at = text.find(piece); at != std::string::npos; at = text.find(piece, at + 1)) ++n;
  return n;
}

// A block of 1 x 2 x 3 m seen towards north: 1 m wide, 3 m high, so 32 x 96 px of 132 x 112 with a margin of 8.
TEST(RockPicture, HasTheBodysSizeAndScale) {
  const auto mesh = testing::block(1, 2, 3);
  const auto picture = draw_rock(mesh, {}, 90.0, 132, 112, 8);
  EXPECT_NEAR(picture.m_per_px, 3.0 / 96.0, 1e-12);
  std::size_t inside = 0;
  for (const auto pixel : picture.image.pixels) inside += pixel != 0 ? 1U : 0U;
  EXPECT_NEAR(static_cast<double>(inside), 32.0 * 96.0, 2.0 * 96.0);  // one column each side
  // Towards the east its 2 m side is seen.
  const auto side = draw_rock(mesh, {}, 0.0, 132, 112, 8);
  inside = 0;
  for (const auto pixel : side.image.pixels) inside += pixel != 0 ? 1U : 0U;
  EXPECT_NEAR(static_cast<double>(inside), 64.0 * 96.0, 2.0 * 96.0);
  // What lies to the right in the picture is what azimuth says.
  EXPECT_GT(side.pixel({0, 1, 0}).x(), side.pixel({0, -1, 0}).x());
  EXPECT_GT(picture.pixel({1, 0, 0}).x(), picture.pixel({-1, 0, 0}).x());
  EXPECT_LT(picture.pixel({0, 0, 1}).y(), picture.pixel({0, 0, 0}).y());
}

// Seen from the south, a wall in front hides one behind it, whatever the order of the triangles.
TEST(RockPicture, NearFacesHideFarOnes) {
  const auto mesh = testing::block(1, 2, 3);
  std::vector<std::uint8_t> seen(mesh.triangles.size(), 1);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    if (mesh.area_vector(t).y() > 0.5) seen[t] = 0;  // the north face
  const auto front = draw_rock(mesh, seen, 90.0, 60, 60, 4);
  EXPECT_EQ(
      std::count_if(front.image.pixels.begin(), front.image.pixels.end(), [](auto p) { return p > kSeenColours; }), 0);
  const auto back = draw_rock(mesh, seen, 270.0, 60, 60, 4);
  EXPECT_GT(std::count_if(back.image.pixels.begin(), back.image.pixels.end(), [](auto p) { return p > kSeenColours; }),
            500);
}

TEST(ContactSheet, SortsByGradeThenByAngle) {
  auto rejected = rock("x", survey::Grade::not_measurable, {});
  rejected.rejected = true;
  rejected.reasons = {"too_few_points"};
  const std::vector<SiteRock> rocks{
      rock("a", survey::Grade::screening, 12.0), rock("b", survey::Grade::not_measurable, {}),
      rock("c", survey::Grade::measured, 25.0),  rejected,
      rock("d", survey::Grade::measured, 18.0),  rock("e", survey::Grade::screening, 9.0)};
  EXPECT_THAT(sheet_order(rocks), ElementsAre(4, 2, 5, 0, 1));
  const std::string bars = grade_histogram(rocks).str();
  EXPECT_THAT(bars, HasSubstr("15 to 20 degrees: 1 measured"));
  EXPECT_THAT(bars, HasSubstr("no angle: 1 "));
  EXPECT_THAT(reject_chart(rocks).str(), HasSubstr("too few points"));
  EXPECT_TRUE(reject_chart({rocks[0]}).empty());
  EXPECT_TRUE(site_map(rocks).empty());  // nowhere
}

TEST(ContactSheet, CopesWithTwoHundredRocksAndHostileNames) {
  const auto mesh = testing::block(1, 2, 3);
  std::vector<SiteRock> rocks;
  for (int i = 0; i < 200; ++i) {
    rocks.push_back(rock("<script>" + std::to_string(i), survey::Grade::bounded, 5.0 + 0.2 * i));
    rocks.back().picture = sheet_picture(mesh, {}, 10.0 * i);
    rocks.back().centre_of_mass = geometry::Vec3(0, 0, 1.5);
    rocks.back().contact = {{-.5, -1, 0}, {.5, -1, 0}, {.5, 1, 0}, {-.5, 1, 0}};
    rocks.back().place = geometry::Vec2(i % 20, i / 20);
  }
  const std::string page = site_page("Site", {}, rocks, true);
  EXPECT_EQ(count(page, "<image "), 200U);
  EXPECT_EQ(count(page, "<script>"), 0U);
  EXPECT_LT(page.size(), 4U << 20U);
  EXPECT_THAT(page, HasSubstr("<h2>Map</h2>"));
  EXPECT_EQ(page.find("<h2>Map</h2>") == std::string::npos, false);
  EXPECT_THAT(site_page("Site", {}, rocks, false), ::testing::Not(HasSubstr("<h2>Map</h2>")));
}

}  // namespace
}  // namespace cairn::report
