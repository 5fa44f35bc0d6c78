#include "report/html_report.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <regex>
#include <string>

#include "base/error.hpp"
#include "support/data.hpp"
#include "support/sample_report.hpp"

namespace cairn::report {
namespace {

// The page without its own bundle, whose code may hold any text.
std::string without_bundle(std::string html) {
  const auto cut = [&html](const std::string& from, const std::string& to) {
    for (std::size_t at = html.find(from); at != std::string::npos; at = html.find(from, at + from.size())) {
      const std::size_t end = html.find(to, at);
      if (end == std::string::npos) break;
      html.erase(at + from.size(), end - at - from.size());
    }
  };
  cut("<style>", "</style>");
  cut("<script>", "</script>");
  return html;
}

std::size_t occurrences(const std::string& text, const std::string& part) {
  std::size_t n = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++n;
  return n;
}

const ReportData& sample() {
  static const ReportData data = testing::sample_report(testing::test_data("report"));
  return data;
}

const std::string& sample_page() {
  static const std::string html = render_report(sample());
  return html;
}

TEST(HtmlReport, equal_data_give_equal_bytes) {
  EXPECT_EQ(render_report(testing::sample_report(testing::test_data("report"))), sample_page());
}

TEST(HtmlReport, loads_nothing) {
  const std::string& html = sample_page();
  EXPECT_NE(html.find("default-src &#39;none&#39;"), std::string::npos);
  // The name of SVG's namespace is no address that is visited.
  const std::string page =
      std::regex_replace(without_bundle(html), std::regex("xmlns=\"http://www.w3.org/2000/svg\""), "");
  EXPECT_FALSE(std::regex_search(
      page, std::regex("<(script|iframe|object|embed|link|base|form|video|audio)[^>]*(src|href|data|action)=",
                       std::regex::icase)));
  EXPECT_EQ(page.find("http://"), std::string::npos);
  EXPECT_EQ(page.find("https://"), std::string::npos);
  EXPECT_EQ(html.find("url(http"), std::string::npos);
  EXPECT_EQ(html.find("@import"), std::string::npos);
  for (std::size_t at = page.find("src=\""); at != std::string::npos; at = page.find("src=\"", at + 1))
    EXPECT_EQ(page.compare(at + 5, 5, "data:"), 0) << page.substr(at, 40);
}

TEST(HtmlReport, every_object_has_a_row_a_symbol_and_an_article) {
  const std::string page = without_bundle(sample_page());
  const std::size_t n = sample().targets.size();
  EXPECT_EQ(occurrences(page, "<article class=\"object\""), n);
  EXPECT_EQ(occurrences(page, "<a class=\"target"), n);
  EXPECT_EQ(occurrences(page, "<th scope=\"row\" class=\"n\" data-v="), n);
  EXPECT_NE(page.find("41 objects were located"), std::string::npos);
}

// Numbers that the data carry, but that the grade forbids, must not appear anywhere: neither in the
// text, nor in attributes, nor in the data for the script.
TEST(HtmlReport, a_rock_that_is_not_measurable_shows_no_tipping_figure) {
  ReportData data = testing::tiny_report();
  RockView rock = testing::sample_rock(1, {10, 5, 2}, 1.0, 1.3, survey::Grade::measured);
  rock.rock.tipping.grade = survey::Grade::not_measurable;
  rock.rock.tipping.reasons = {"too_coarse"};
  rock.rock.tipping.critical = survey::TippingEdge{217.0, 0.31337, 0.77123, 3.98765, 0.32445, 1.65432};
  rock.rock.tipping.a_qs_g_by_azimuth.assign(360, 0.86421);
  data.rocks = {rock};
  const std::string page = without_bundle(render_report(data));
  for (const char* figure : {"0.31337", "17.95", "18.0<", "217", "0.771", "3.99", "0.324", "1.65", "0.864"})
    EXPECT_EQ(page.find(figure), std::string::npos) << figure;
  EXPECT_NE(page.find("No tipping figure is given"), std::string::npos);
  EXPECT_NE(page.find("The points are too far apart"), std::string::npos);
  EXPECT_EQ(page.find("class=\"polar\""), std::string::npos);

  data.rocks[0].rock.tipping.grade = survey::Grade::measured;
  const std::string allowed = without_bundle(render_report(data));
  EXPECT_NE(allowed.find("18.0"), std::string::npos);
  EXPECT_NE(allowed.find("class=\"polar\""), std::string::npos);
}

TEST(HtmlReport, text_of_the_data_never_becomes_markup) {
  const std::string page = without_bundle(render_report(testing::hostile_report()));
  EXPECT_EQ(occurrences(page, "<script"), 3U) << "two own scripts and the data";
  EXPECT_EQ(occurrences(page, "</script"), 3U);
  EXPECT_EQ(page.find("<img src=x"), std::string::npos);
  EXPECT_FALSE(std::regex_search(page, std::regex("<[^>]*\\son[a-z]+=\"", std::regex::icase)));
  EXPECT_EQ(page.find("href=\"javascript:"), std::string::npos);
  EXPECT_EQ(page.find("image/png\" onload"), std::string::npos) << "a media type that is not known is refused";
  EXPECT_EQ(page.find('\0'), std::string::npos);
}

TEST(HtmlReport, sections_without_data_are_left_out) {
  const std::string page = without_bundle(render_report(testing::tiny_report()));
  for (const char* part :
       {"id=\"coverage\"", "id=\"ground\"", "data-layer=\"views\"", "u-relief", "href=\"#coverage\""})
    EXPECT_EQ(page.find(part), std::string::npos) << part;
  EXPECT_NE(page.find("id=\"provenance\""), std::string::npos);
  ReportData empty;
  EXPECT_NE(render_report(empty).find("id=\"reading\""), std::string::npos);
}

TEST(HtmlReport, no_number_that_is_not_finite_is_printed) {
  ReportData data = testing::tiny_report();
  data.targets[0].target.centre.z() = std::nan("");
  data.targets[0].target.covariance(2, 2) = std::nan("");
  const std::string page = without_bundle(render_report(data));
  EXPECT_EQ(page.find(">nan"), std::string::npos);
  EXPECT_EQ(page.find("NaN"), std::string::npos);
}

TEST(HtmlReport, data_that_contradict_themselves_are_refused) {
  ReportData grid = testing::tiny_report();
  grid.rasters.push_back({RasterRole::surface, geometry::Grid<float>({0, 0, 1, 4, 4}, 0.0F), "m"});
  grid.rasters[0].grid.values.pop_back();
  EXPECT_THROW((void)render_report(grid), base::Error);

  ReportData polar = testing::tiny_report();
  polar.rocks.push_back(testing::sample_rock(1, {0, 0, 0}, 1, 1, survey::Grade::measured));
  polar.rocks[0].rock.tipping.a_qs_g_by_azimuth.pop_back();
  EXPECT_THROW((void)render_report(polar), base::Error);

  ReportData mesh = testing::tiny_report();
  mesh.rocks.push_back(testing::sample_rock(1, {0, 0, 0}, 1, 1, survey::Grade::measured));
  mesh.rocks[0].mesh->triangles[0][1] = 4000000;
  EXPECT_THROW((void)render_report(mesh), base::Error);

  ReportOptions options;
  options.max_raster_px = 3;
  EXPECT_THROW((void)render_report(testing::tiny_report(), options), base::Error);
}

TEST(HtmlReport, a_survey_of_this_size_stays_small) {
  constexpr std::size_t kLimit = 15U << 20U;  // bytes: what a browser opens at once, and mail takes
  EXPECT_LT(sample_page().size(), kLimit);
}

}  // namespace
}  // namespace cairn::report
