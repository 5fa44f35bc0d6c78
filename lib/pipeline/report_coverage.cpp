#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string>
#include <string_view>

#include "base/number_text.hpp"
#include "io/gaps_json.hpp"
#include "io/json.hpp"
#include "pipeline/report_parts.hpp"

namespace cairn::pipeline {
namespace {

// A metric as it may stand in a raster band, with the bins that people expect.
struct Metric {
  std::string_view prefix, title, unit;
  double step, last;
  bool gate_is_minimum;
};
constexpr std::array kMetrics{
    Metric{"views", "Views of a cell", "", 1.0, 16.0, true},
    Metric{"gsd", "Best ground sampling distance", "mm/px", 0.0, 0.0, false},
    Metric{"incidence", "Best incidence", "°", 5.0, 90.0, false},
    Metric{"parallax", "Greatest parallax", "°", 5.0, 90.0, true},
};
constexpr int kFreeBins = 20;  // of a metric without bins of its own

std::string text_of(const io::Json& json, std::string_view key) {
  const io::Json* value = json.find(key);
  return value != nullptr && value->is_string() ? value->as_string() : std::string();
}
double real_of(const io::Json& json, std::string_view key, double otherwise = 0.0) {
  const io::Json* value = json.find(key);
  return value != nullptr && value->is_number() ? value->as_real() : otherwise;
}
std::vector<double> reals_of(const io::Json& json, std::string_view key) {
  std::vector<double> out;
  if (const io::Json* list = json.find(key); list != nullptr && list->is_array())
    for (const io::Json& v : list->as_array()) out.push_back(v.as_real());
  return out;
}

report::Histogram histogram_of(const Metric& metric, const std::vector<double>& values, double cell_area) {
  report::Histogram h;
  h.metric = metric.prefix;
  h.title = metric.title;
  h.unit = metric.unit;
  h.gate_is_minimum = metric.gate_is_minimum;
  const auto [lo, hi] = std::minmax_element(values.begin(), values.end());
  double from = 0.0, step = metric.step;
  auto bins = static_cast<int>(std::lround(metric.step > 0.0 ? metric.last / metric.step : kFreeBins));
  if (step <= 0.0) {
    from = std::floor(*lo);
    step = std::max(1e-6, (std::ceil(*hi) - from) / kFreeBins);
  } else {
    // Empty bins on the right say nothing.
    bins = std::clamp(static_cast<int>(std::floor(*hi / step)) + 1, 1, bins);
  }
  for (int i = 0; i <= bins; ++i) h.edges.push_back(from + step * i);
  h.areas_m2.assign(static_cast<std::size_t>(bins), 0.0);
  for (const double v : values) {
    const int bin = std::clamp(static_cast<int>(std::floor((v - from) / step)), 0, bins - 1);
    h.areas_m2[static_cast<std::size_t>(bin)] += cell_area;
  }
  return h;
}

std::vector<double> finite_values(const io::RasterBand& band, double& cell_area) {
  std::vector<double> values;
  std::visit(
      [&](const auto& grid) {
        cell_area = grid.geometry.cell * grid.geometry.cell;
        for (const auto v : grid.values) {
          const auto value = static_cast<double>(v);
          if constexpr (std::is_integral_v<std::decay_t<decltype(v)>>) {
            if (band.nodata && static_cast<std::int64_t>(v) == *band.nodata) continue;
          }
          if (std::isfinite(value)) values.push_back(value);
        }
      },
      band.values);
  return values;
}

std::vector<report::Histogram> histograms_of(const io::Raster& views) {
  std::vector<report::Histogram> out;
  for (const Metric& metric : kMetrics)
    for (const io::RasterBand& band : views.bands) {
      if (!std::string_view(band.name).starts_with(metric.prefix)) continue;
      double cell_area = 0.0;
      const std::vector<double> values = finite_values(band, cell_area);
      if (values.empty()) continue;
      out.push_back(histogram_of(metric, values, cell_area));
      break;  // one band a metric: the best, which stands first
    }
  return out;
}

std::vector<report::GapView> gaps_of(const std::filesystem::path& file, const survey::Survey& survey) {
  std::vector<report::GapView> out;
  if (file.empty()) return out;
  for (const survey::CoverageGap& gap : io::read_gaps(file).gaps) {
    report::GapView view;
    view.id = gap.id.value;
    view.rings = gap.rings;
    view.centroid = gap.centre.head<2>();
    view.area_m2 = gap.area_m2;
    view.reasons = {gap.reason};
    for (const survey::FrameId id : gap.nearest_frames) {
      const survey::Frame* frame = survey.frame(id);
      view.nearest_frames.push_back(frame == nullptr || frame->image.empty()
                                        ? "frame " + std::to_string(id.value)
                                        : std::filesystem::path(frame->image).filename().string());
    }
    if (gap.view) {
      const geometry::Vec3& p = gap.view->position;
      view.suggestion = "A view from east " + base::to_fixed(p.x(), 1) + ", north " + base::to_fixed(p.y(), 1) +
                        ", up " + base::to_fixed(p.z(), 1) + " m, looking at the gap, would help.";
    }
    out.push_back(std::move(view));
  }
  return out;
}

// "at most 60 deg in two views" -> "at most 60° in two views"
std::string with_degree_sign(std::string rule) {
  if (const auto at = rule.find(" deg"); at != std::string::npos) rule.replace(at, 4, "°");
  return rule;
}

// Long thin tails would press the rest into a few pixels: bins that hold together less than `kTail` of the area at
// either end are folded into their neighbour. Bins up to the gate stay.
report::Histogram trimmed(report::Histogram h) {
  constexpr double kTail = 0.002;
  constexpr std::size_t kFewBins = 20;  // that many fit as they are
  if (h.areas_m2.size() < 2 || h.edges.size() != h.areas_m2.size() + 1) return h;
  double total = 0.0;
  for (const double a : h.areas_m2) total += a;
  const auto holds_gate = [&](std::size_t i) { return h.gate && *h.gate >= h.edges[i] && *h.gate <= h.edges[i + 1]; };
  std::size_t first = 0, last = h.areas_m2.size() - 1;
  double tail = 0.0;
  while (last > first && !holds_gate(last) && tail + h.areas_m2[last] <= kTail * total) tail += h.areas_m2[last--];
  h.areas_m2[last] += tail;
  tail = 0.0;
  if (last >= kFewBins)
    while (first < last && !holds_gate(first) && tail + h.areas_m2[first] <= kTail * total) tail += h.areas_m2[first++];
  h.areas_m2[first] += tail;
  const auto at = [](auto& list, std::size_t i) { return list.begin() + static_cast<std::ptrdiff_t>(i); };
  h.areas_m2 = {at(h.areas_m2, first), at(h.areas_m2, last + 1)};
  h.edges = {at(h.edges, first), at(h.edges, last + 2)};
  return h;
}

void read_gates(report::CoverageView& view, const io::Json& json) {
  const io::Json* gates = json.find("gates");
  if (gates == nullptr || !gates->is_array()) return;
  for (const io::Json& gate : gates->as_array())
    view.gates.push_back(
        {text_of(gate, "name"), with_degree_sign(text_of(gate, "rule")), real_of(gate, "pass_fraction")});
}

void read_histograms(report::CoverageView& view, const io::Json& json) {
  const io::Json* list = json.find("histograms");
  if (list == nullptr || !list->is_array()) return;
  for (const io::Json& item : list->as_array()) {
    report::Histogram h;
    h.metric = text_of(item, "metric");
    h.title = text_of(item, "title");
    h.unit = text_of(item, "unit");
    h.edges = reals_of(item, "edges");
    h.areas_m2 = reals_of(item, "areas_m2");
    if (const io::Json* gate = item.find("gate"); gate != nullptr && gate->is_number()) h.gate = gate->as_real();
    if (const io::Json* side = item.find("gate_is_minimum"); side != nullptr && side->is_bool())
      h.gate_is_minimum = side->as_bool();
    if (h.unit == "deg") h.unit = "°";
    view.histograms.push_back(trimmed(std::move(h)));
  }
}

}  // namespace

std::optional<report::CoverageView> read_coverage_view(const ReportInputs& in, const survey::Survey& survey,
                                                       const std::optional<io::Raster>& views) {
  const auto file = in.product("coverage", "coverage.json");
  if (file.empty()) return std::nullopt;
  const io::Json json = io::read_json(file);
  report::CoverageView view;
  view.facets = static_cast<std::size_t>(std::max(0.0, real_of(json, "facets")));
  view.area_m2 = real_of(json, "area_m2");
  if (const io::Json* verdicts = json.find("area_m2_by_verdict"); verdicts != nullptr && verdicts->is_object())
    for (const auto& [verdict, area] : verdicts->as_object()) view.verdicts.push_back({verdict, area.as_real()});
  view.complete_fraction = real_of(json, "completeness");
  if (const auto interval = reals_of(json, "completeness_interval_95"); interval.size() == 2)
    view.interval_95 = {interval[0], interval[1]};
  if (const std::string sentence = text_of(json, "validation"); !sentence.empty()) view.validation = sentence;
  read_gates(view, json);
  read_histograms(view, json);
  if (view.histograms.empty() && views) view.histograms = histograms_of(*views);
  view.gaps = gaps_of(in.product("coverage", "gaps.json"), survey);
  return view;
}

}  // namespace cairn::pipeline
