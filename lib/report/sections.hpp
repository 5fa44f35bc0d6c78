// The parts of the page. Internal to the report: html_report.cpp puts them together.
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "geodesy/local_frame.hpp"
#include "geometry/primitives.hpp"
#include "report/html_report.hpp"
#include "report/html_text.hpp"
#include "report/palette.hpp"
#include "report/report_data.hpp"

namespace cairn::report {

// What several sections look up.
struct PageContext {
  PageContext(const ReportData& report_data, const ReportOptions& report_options);

  const ReportData& data;
  const ReportOptions& options;
  geodesy::LocalFrame frame;
  std::string title;
  std::vector<std::string> classes;  // of targets and obstacles, sorted
  std::map<std::string, ClassStyle, std::less<>> styles;
  std::map<std::int64_t, const RockView*> rock_of;                                      // by target id
  geometry::Vec2 view_min = geometry::Vec2::Zero(), view_max = geometry::Vec2::Zero();  // map at the start, m

  [[nodiscard]] ClassStyle style(std::string_view object_class) const;
  [[nodiscard]] const RockView* rock(survey::TargetId id) const;
  [[nodiscard]] const RasterView* raster(RasterRole role) const;
};

// Sections without data give an empty Html.
[[nodiscard]] Html header_section(const PageContext& page);
[[nodiscard]] Html summary_section(const PageContext& page);
[[nodiscard]] Html map_figure(const PageContext& page);
[[nodiscard]] Html object_panel(const PageContext& page);  // one article a target
[[nodiscard]] Html table_section(const PageContext& page);
[[nodiscard]] Html site_section(const PageContext& page);  // two rocks or more
[[nodiscard]] Html coverage_section(const PageContext& page);
[[nodiscard]] Html ground_section(const PageContext& page);
[[nodiscard]] Html provenance_section(const PageContext& page);
[[nodiscard]] Html reading_section();

// Shared pieces.
[[nodiscard]] Html grade_badge(survey::Grade grade);
[[nodiscard]] Html class_symbol(const PageContext& page, std::string_view object_class);
// The outline of a map symbol of about 6 units radius: the `d` of a path.
[[nodiscard]] std::string_view symbol_path(std::string_view shape);
[[nodiscard]] std::string fixed(double value, int decimals);  // with a true minus sign
[[nodiscard]] std::string grouped(std::size_t count);         // thin spaces between thousands
[[nodiscard]] std::string plural(std::size_t count, std::string_view one, std::string_view many);
[[nodiscard]] std::string words_of(std::string_view code);  // blanks for underscores
[[nodiscard]] std::string latitude_text(double degrees);
[[nodiscard]] std::string longitude_text(double degrees);
// One sigma of the horizontal position: sqrt of the greater eigenvalue of the east-north covariance, m.
[[nodiscard]] double horizontal_sigma(const geometry::Mat3& covariance);

}  // namespace cairn::report
