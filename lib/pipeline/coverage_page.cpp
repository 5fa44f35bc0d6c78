#include <algorithm>
#include <cmath>
#include <filesystem>
#include <utility>

#include "base/atomic_file.hpp"
#include "base/number_text.hpp"
#include "pipeline/coverage_products.hpp"
#include "report/coverage_page.hpp"

namespace cairn::pipeline {
namespace {

using geometry::Grid;

std::optional<double> known(double value) {
  return std::isfinite(value) ? std::optional(value) : std::nullopt;
}

std::vector<double> reals(const io::Json& list) {
  std::vector<double> values;
  for (const io::Json& v : list.as_array()) values.push_back(v.as_real());
  return values;
}

// "at most 60 deg in two views" -> "at most 60° in two views"
std::string with_degree_sign(std::string rule) {
  if (const auto at = rule.find(" deg"); at != std::string::npos) rule.replace(at, 4, "°");
  return rule;
}

// Thin tails would press the rest into a few pixels: classes at the ends that hold together less than `kTail` of the
// area are folded into their neighbour; at the left only where there are many. Classes up to the gate stay.
report::Histogram trimmed(report::Histogram h) {
  constexpr double kTail = 0.002;
  constexpr std::size_t kMany = 40;
  double total = 0.0;
  for (const double a : h.areas_m2) total += a;
  const auto holds_gate = [&h] {
    return h.gate && *h.gate >= h.edges[h.edges.size() - 2] && *h.gate <= h.edges.back();
  };
  while (h.areas_m2.size() > 1 && !holds_gate() && h.areas_m2.back() <= kTail * total) {
    const double tail = h.areas_m2.back();
    h.areas_m2.pop_back();
    h.edges.pop_back();
    h.areas_m2.back() += tail;
  }
  if (h.areas_m2.size() < kMany) return h;
  const auto first = std::find_if(h.areas_m2.begin(), h.areas_m2.end(), [&](double a) { return a > kTail * total; });
  const auto dropped = first - h.areas_m2.begin();
  if (first == h.areas_m2.end() || (h.gate && *h.gate < h.edges[static_cast<std::size_t>(dropped)])) return h;
  h.areas_m2.erase(h.areas_m2.begin(), first);
  h.edges.erase(h.edges.begin(), h.edges.begin() + dropped);
  return h;
}

report::CoverageView view_of(const io::Json& summary, const io::Json& histograms,
                             const std::vector<survey::CoverageGap>& gaps) {
  report::CoverageView view;
  view.area_m2 = summary.at("area_m2").as_real();
  view.complete_fraction = summary.at("completeness").as_real();
  if (const io::Json* interval = summary.find("completeness_interval_95")) {
    const auto ends = reals(*interval);
    view.interval_95 = {ends[0], ends[1]};
  }
  for (const auto& [verdict, area] : summary.at("area_m2_by_verdict").as_object())
    view.verdicts.push_back({verdict, area.as_real()});
  for (const io::Json& gate : summary.at("gates").as_array())
    view.gates.push_back({gate.at("name").as_string(), with_degree_sign(gate.at("rule").as_string()),
                          gate.at("pass_fraction").as_real()});
  for (const io::Json& h : histograms.as_array()) {
    report::Histogram histogram;
    histogram.metric = h.at("metric").as_string();
    histogram.title = h.at("title").as_string();
    histogram.unit = h.at("unit").as_string() == "deg" ? "°" : h.at("unit").as_string();
    histogram.edges = reals(h.at("edges"));
    histogram.areas_m2 = reals(h.at("areas_m2"));
    if (const io::Json* gate = h.find("gate")) histogram.gate = gate->as_real();
    if (const io::Json* side = h.find("gate_is_minimum")) histogram.gate_is_minimum = side->as_bool();
    view.histograms.push_back(trimmed(std::move(histogram)));
  }
  for (const survey::CoverageGap& gap : gaps) {
    report::GapView row;
    row.id = gap.id.value;
    row.centroid = gap.centre.head<2>();
    row.area_m2 = gap.area_m2;
    row.reasons = {gap.reason};
    for (const survey::FrameId id : gap.nearest_frames) row.nearest_frames.push_back(std::to_string(id.value));
    if (gap.view) {
      const geometry::Vec3& p = gap.view->position;
      row.suggestion = "from east " + base::to_fixed(p.x(), 1) + ", north " + base::to_fixed(p.y(), 1) + ", up " +
                       base::to_fixed(p.z(), 1) + " m";
    }
    view.gaps.push_back(std::move(row));
  }
  return view;
}

// Values between which nearly all of a grid lies.
std::pair<double, double> span_of(const Grid<float>& grid) {
  std::vector<float> values;
  for (const float v : grid.values)
    if (std::isfinite(v)) values.push_back(v);
  if (values.empty()) return {0.0, 1.0};
  std::sort(values.begin(), values.end());
  const auto at = [&values](double share) {
    return static_cast<double>(values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))]);
  };
  return {at(0.02), std::max(at(0.98), at(0.02) + 1e-3)};
}

std::vector<report::CoverageMap> maps_of(const CoverageCells& cells) {
  constexpr int kMost = 10;
  std::vector<report::CoverageMap> maps;
  maps.push_back(report::count_map(cells.views, "Views", "that see the surface, from its front, unobstructed.", kMost));
  maps.push_back(report::count_map(cells.overlap, "Overlap, 2.5-D",
                                   "as other reports count it: frames that have the place inside, seen or not.",
                                   kMost));
  const auto add = [&maps](const Grid<float>& grid, const char* title, const char* note, const char* unit, bool small) {
    const auto [lo, hi] = span_of(grid);
    maps.push_back(report::metric_map(grid, title, note, unit, lo, hi, small));
  };
  add(cells.parallax, "Parallax", "largest angle between two sight lines.", "°", false);
  add(cells.sigma, "Predicted sigma", "of a matched point, along the direction known worst.", "mm", true);
  add(cells.gsd, "Ground sampling distance", "of the best view, on the surface itself.", "mm/px", true);
  add(cells.incidence, "Incidence", "of the best view: angle to the surface's normal.", "°", true);
  return maps;
}

}  // namespace

void write_coverage_page(const std::filesystem::path& path, const std::string& title, const io::Json& summary,
                         const io::Json& histograms, const std::vector<survey::CoverageGap>& gaps,
                         const std::vector<FrameFigures>& frames, const std::vector<coverage::TargetAudit>& targets,
                         const std::optional<CoverageCells>& cells, double max_blur_px,
                         const std::vector<std::string>& notes) {
  report::CoveragePage page;
  page.title = title;
  page.coverage = view_of(summary, histograms, gaps);
  const io::Json& sides = summary.at("sides");
  if (const io::Json* complete = sides.find("completeness")) {
    page.sides_complete = complete->as_real();
    page.sides_area_m2 = sides.at("area_m2").as_real();
  }
  if (const io::Json* interval = summary.find("interval")) page.block_m = interval->at("block_m").as_real();
  if (cells) page.maps = maps_of(*cells);
  page.blur_limit_px = max_blur_px;
  page.notes = notes;
  for (const coverage::TargetAudit& t : targets) {
    report::CoverageTargetRow row;
    row.label = std::to_string(t.id.value);
    row.passed = t.passed;
    for (const std::string& reason : t.reasons) row.reasons += (row.reasons.empty() ? "" : ", ") + reason;
    std::replace(row.reasons.begin(), row.reasons.end(), '_', ' ');
    row.height_m = t.cylinder.height();
    row.width_m = 2.0 * t.cylinder.radius;
    row.wall = t.wall.completeness();
    row.top = t.top.completeness();
    row.basal = t.basal.seen_share;
    row.wall_gsd_mm = known(t.wall.gsd_median_mm);
    row.basal_gsd_mm = known(t.basal.gsd_best_mm);
    row.sigma_mm = known(t.sigma_95_mm);
    row.azimuth_bins = t.azimuth_bins;
    row.contact_known = t.basal.contact_known;
    row.wall_by_azimuth.assign(t.wall_by_azimuth.begin(), t.wall_by_azimuth.end());
    row.basal_by_azimuth.assign(t.basal.seen_by_azimuth.begin(), t.basal.seen_by_azimuth.end());
    page.targets.push_back(std::move(row));
  }
  for (const FrameFigures& f : frames) {
    const std::string name = std::filesystem::path(f.image).filename().string();
    page.frames.push_back({name.empty() ? "frame " + std::to_string(f.frame.value) : name, f.gsd_mm, f.speed_m_s,
                           f.exposure_s, f.blur_px});
  }
  base::write_file(path, report::render_coverage_page(page));
}

}  // namespace cairn::pipeline
