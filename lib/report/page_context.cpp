#include <algorithm>
#include <cmath>
#include <set>

#include "base/number_text.hpp"
#include "report/definitions.hpp"
#include "report/sections.hpp"

namespace cairn::report {

PageContext::PageContext(const ReportData& report_data, const ReportOptions& report_options)
    : data(report_data), options(report_options), frame(report_data.manifest.origin.position) {
  title = !options.title.empty() ? options.title : !data.manifest.name.empty() ? data.manifest.name : "Survey";
  std::set<std::string> names;
  for (const TargetView& t : data.targets) names.insert(t.target.object_class);
  for (const survey::Obstacle& o : data.obstacles) names.insert(o.object_class);
  classes.assign(names.begin(), names.end());
  for (std::size_t i = 0; i < classes.size(); ++i) styles.emplace(classes[i], class_style(classes[i], i));
  for (const RockView& r : data.rocks) rock_of.emplace(r.rock.target.value, &r);

  bool any = false;
  const auto extend = [&](const geometry::Vec2& p) {
    if (!p.allFinite()) return;
    view_min = any ? geometry::Vec2(view_min.cwiseMin(p)) : p;
    view_max = any ? geometry::Vec2(view_max.cwiseMax(p)) : p;
    any = true;
  };
  for (const RasterView& r : data.rasters) {
    extend({r.grid.geometry.west, r.grid.geometry.north});
    extend({r.grid.geometry.east(), r.grid.geometry.south()});
  }
  for (const TargetView& t : data.targets) extend(t.target.centre.head<2>());
  for (const survey::Obstacle& o : data.obstacles) extend(o.position.head<2>());
  for (const FrameView& f : data.frames) extend(f.frame.T_world_camera.translation.head<2>());
  if (data.route)
    for (const geometry::Vec2& p : data.route->path) extend(p);
  const double margin = std::max(3.0, 0.04 * (view_max - view_min).maxCoeff());
  view_min -= geometry::Vec2::Constant(margin);
  view_max += geometry::Vec2::Constant(margin);
}

ClassStyle PageContext::style(std::string_view object_class) const {
  const auto it = styles.find(object_class);
  return it == styles.end() ? class_style(object_class, 0) : it->second;
}

const RockView* PageContext::rock(survey::TargetId id) const {
  const auto it = rock_of.find(id.value);
  return it == rock_of.end() ? nullptr : it->second;
}

const RasterView* PageContext::raster(RasterRole role) const {
  for (const RasterView& r : data.rasters)
    if (r.role == role) return &r;
  return nullptr;
}

Html grade_badge(survey::Grade grade) {
  Html h;
  h.raw("<span")
      .attr("class", "badge grade-" + std::string(survey::name_of(grade)))
      .attr("title", grade_meaning(grade))
      .raw(">")
      .text(grade_label(grade))
      .raw("</span>");
  return h;
}

std::string_view symbol_path(std::string_view shape) {
  if (shape == "square") return "M-5-5H5V5H-5Z";
  if (shape == "triangle") return "M0-6.4L5.9 4.6H-5.9Z";
  if (shape == "diamond") return "M0-6.6L6.2 0L0 6.6L-6.2 0Z";
  if (shape == "pentagon") return "M0-6L5.7-1.9L3.5 4.9H-3.5L-5.7-1.9Z";
  if (shape == "cross") return "M-2-6H2V-2H6V2H2V6H-2V2H-6V-2H-2Z";
  return "M-5.4 0A5.4 5.4 0 1 0 5.4 0A5.4 5.4 0 1 0 -5.4 0Z";
}

Html class_symbol(const PageContext& page, std::string_view object_class) {
  const ClassStyle style = page.style(object_class);
  Html h;
  h.raw("<svg class=\"symbol\" viewBox=\"-8 -8 16 16\" aria-hidden=\"true\"><path")
      .attr("d", symbol_path(style.shape))
      .attr("fill", style.colour)
      .raw("/></svg>");
  return h;
}

std::string fixed(double value, int decimals) {
  if (!std::isfinite(value)) return "–";
  std::string text = base::to_fixed(value, decimals);
  if (!text.empty() && text.front() == '-') text.replace(0, 1, "\u2212");
  return text;
}

std::string grouped(std::size_t count) {
  std::string digits = std::to_string(count), out;
  for (std::size_t i = 0; i < digits.size(); ++i) {
    if (i > 0 && (digits.size() - i) % 3 == 0) out += "\u202f";
    out += digits[i];
  }
  return out;
}

std::string plural(std::size_t count, std::string_view one, std::string_view many) {
  return grouped(count) + " " + std::string(count == 1 ? one : many);
}

std::string words_of(std::string_view code) {
  std::string text(code);
  std::replace(text.begin(), text.end(), '_', ' ');
  return text;
}

std::string latitude_text(double degrees) {
  if (!std::isfinite(degrees)) return "–";
  return base::to_fixed(std::abs(degrees), 7) + "° " + (degrees < 0.0 ? "S" : "N");
}
std::string longitude_text(double degrees) {
  if (!std::isfinite(degrees)) return "–";
  return base::to_fixed(std::abs(degrees), 7) + "° " + (degrees < 0.0 ? "W" : "E");
}

double horizontal_sigma(const geometry::Mat3& c) {
  const double mean = 0.5 * (c(0, 0) + c(1, 1)), half = 0.5 * (c(0, 0) - c(1, 1));
  return std::sqrt(std::max(0.0, mean + std::hypot(half, c(0, 1))));
}

}  // namespace cairn::report
