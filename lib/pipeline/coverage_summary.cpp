#include "pipeline/coverage_summary.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <string>
#include <utility>

#include "base/number_text.hpp"
#include "base/parallel.hpp"

namespace cairn::pipeline {
namespace {

using coverage::Audit;
using coverage::FacetCoverage;
using coverage::GateOptions;
using coverage::Verdict;

// A facet's value of a metric, NaN where it has none.
using Value = std::function<double(std::size_t)>;

struct Observed {
  std::vector<std::uint32_t> facets;  // observed, with an area
  std::vector<double> area_m2;
  double total_m2 = 0.0;
};

Observed observed_facets(const geometry::TriangleMesh& mesh, const Audit& audit) {
  Observed result;
  for (std::size_t i = 0; i < audit.verdicts.size(); ++i) {
    if (audit.verdicts[i] == Verdict::no_data) continue;
    const auto& t = mesh.triangles[i];
    const std::size_t count = mesh.vertices.size();
    if (t[0] >= count || t[1] >= count || t[2] >= count) continue;
    const double area = mesh.area_vector(i).norm();
    if (!(std::isfinite(area) && area > 0.0)) continue;
    result.facets.push_back(static_cast<std::uint32_t>(i));
    result.area_m2.push_back(area);
  }
  result.total_m2 = base::deterministic_sum(result.area_m2);
  return result;
}

io::Json histogram(const Observed& o, const std::string& metric, const std::string& title, const std::string& unit,
                   const std::vector<double>& edges, const Value& value, double gate, bool gate_is_minimum) {
  std::vector<double> areas(edges.size() - 1, 0.0);
  for (std::size_t k = 0; k < o.facets.size(); ++k) {
    const double v = value(o.facets[k]);
    if (!std::isfinite(v)) continue;
    const auto above = std::upper_bound(edges.begin(), edges.end(), v) - edges.begin();
    // The last class holds everything above it, the first everything below.
    const auto last = static_cast<std::ptrdiff_t>(areas.size()) - 1;
    areas[static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(above - 1, 0, last))] += o.area_m2[k];
  }
  io::Json h =
      io::Json::object({{"metric", metric}, {"title", title}, {"unit", unit}, {"edges", edges}, {"areas_m2", areas}});
  if (gate > 0.0) {
    h.set("gate", gate);
    h.set("gate_is_minimum", gate_is_minimum);
  }
  return h;
}

using Weighted = std::vector<std::pair<double, double>>;  // value, weight

// The value at which the weights of the smaller ones and its own reach `weight`. Reorders the values.
double weighted_select(Weighted& values, double weight) {
  auto begin = values.begin(), end = values.end();
  constexpr std::ptrdiff_t kFew = 32;
  while (end - begin > kFew) {
    const auto middle = begin + (end - begin) / 2;
    std::nth_element(begin, middle, end);
    double left = 0.0;
    for (auto it = begin; it != middle; ++it) left += it->second;
    if (left >= weight) {
      end = middle;
    } else {
      weight -= left;
      begin = middle;
    }
  }
  std::sort(begin, end);
  for (; begin != end - 1; ++begin)
    if ((weight -= begin->second) <= 0.0) break;
  return begin->first;
}

// Area-weighted percentiles over the facets that have the value.
io::Json percentiles(const Observed& o, const Value& value) {
  Weighted values;
  double total = 0.0;
  for (std::size_t k = 0; k < o.facets.size(); ++k) {
    const double v = value(o.facets[k]);
    if (!std::isfinite(v)) continue;
    values.emplace_back(v, o.area_m2[k]);
    total += o.area_m2[k];
  }
  if (values.empty()) return {};
  const auto at = [&](double share) { return weighted_select(values, share * total); };
  return io::Json::object({{"p5", at(0.05)}, {"median", at(0.5)}, {"p95", at(0.95)}});
}

// Walls and undersides apart: what a flight that looks straight down fails to see.
io::Json sides(const geometry::TriangleMesh& mesh, const Observed& o, const Audit& audit) {
  constexpr double kRise = 0.2;  // of the unit normal
  std::array<double, coverage::kVerdicts> by_verdict{};
  double total = 0.0;
  for (std::size_t k = 0; k < o.facets.size(); ++k) {
    const geometry::Vec3 a = mesh.area_vector(o.facets[k]);
    if (!(a.z() < kRise * a.norm())) continue;
    by_verdict[static_cast<std::size_t>(audit.verdicts[o.facets[k]])] += o.area_m2[k];
    total += o.area_m2[k];
  }
  io::Json areas = io::Json::object();
  for (std::size_t v = 0; v < coverage::kVerdicts; ++v)
    areas.set(std::string(coverage::name_of(static_cast<Verdict>(v))), by_verdict[v]);
  io::Json result = io::Json::object({{"area_m2", total}, {"area_m2_by_verdict", std::move(areas)}});
  if (total > 0.0) result.set("completeness", by_verdict[static_cast<std::size_t>(Verdict::passed)] / total);
  return result;
}

std::vector<double> even_edges(double step, int count) {
  std::vector<double> edges;
  for (int i = 0; i <= count; ++i) edges.push_back(step * i);
  return edges;
}

}  // namespace

CoverageFigures coverage_figures(const geometry::TriangleMesh& mesh, const FacetCoverage& m, const Audit& audit,
                                 const GateOptions& gates) {
  const Observed o = observed_facets(mesh, audit);
  const auto column = [](const std::vector<float>& values) {
    return [&values](std::size_t i) { return static_cast<double>(values[i]); };
  };
  const Value views = [&m](std::size_t i) { return static_cast<double>(m.views[i]); };
  const Value gsd = column(m.gsd_best_mm), sigma = column(m.sigma_max_mm),
              overlap = [&m](std::size_t i) { return static_cast<double>(m.in_frame[i]); };
  const Value azimuths = [&m](std::size_t i) { return static_cast<double>(coverage::azimuth_bins(m.azimuths[i])); };
  const Value parallax = column(m.parallax_deg), best = column(m.incidence_best_deg);
  const Value incidence = gates.min_views < 2 ? best : Value(column(m.incidence_second_deg));

  CoverageFigures figures;
  figures.histograms = io::Json::array();
  const auto most = static_cast<double>(
      std::max<std::uint32_t>(1, m.views.empty() ? 1 : *std::max_element(m.views.begin(), m.views.end())));
  figures.histograms.push(histogram(o, "views", "Views of a facet", "",
                                    even_edges(1.0, static_cast<int>(std::min(most, 50.0)) + 1), views,
                                    static_cast<double>(gates.min_views), true));
  const auto gsd_spread = percentiles(o, gsd);
  const double gsd_step =
      gsd_spread.is_null()
          ? 1.0
          : std::pow(10.0, std::floor(std::log10(std::max(gsd_spread.at("p95").as_real(), 1e-6)))) / 10.0;
  figures.histograms.push(histogram(o, "gsd_mm", "Best ground sampling distance", "mm/px", even_edges(gsd_step, 100),
                                    gsd, gates.max_gsd_mm, false));
  figures.histograms.push(histogram(o, "incidence_deg", "Best angle of incidence", "deg", even_edges(5.0, 18), best,
                                    gates.max_incidence_deg, false));
  figures.histograms.push(histogram(o, "parallax_deg", "Largest parallax", "deg", even_edges(5.0, 36), parallax,
                                    gates.min_parallax_deg, true));

  io::Json gate_list = io::Json::array();
  const auto gate = [&](const std::string& name, const std::string& rule, const Value& value, auto passes) {
    std::vector<double> passing;
    for (std::size_t k = 0; k < o.facets.size(); ++k)
      if (passes(value(o.facets[k]))) passing.push_back(o.area_m2[k]);
    const double area = base::deterministic_sum(passing);
    gate_list.push(io::Json::object(
        {{"name", name}, {"rule", rule}, {"pass_fraction", o.total_m2 > 0.0 ? area / o.total_m2 : 0.0}}));
  };
  gate("views", "at least " + std::to_string(gates.min_views), views,
       [&](double v) { return v >= static_cast<double>(gates.min_views); });
  gate("incidence",
       "at most " + base::to_text(gates.max_incidence_deg) + " deg in " +
           (gates.min_views < 2 ? "one view" : "two views"),
       incidence, [&](double v) { return v <= gates.max_incidence_deg; });
  if (gates.max_gsd_mm > 0.0)
    gate("gsd", "best at most " + base::to_text(gates.max_gsd_mm) + " mm/px", gsd,
         [&](double v) { return v <= gates.max_gsd_mm; });
  if (gates.min_parallax_deg > 0.0)
    gate("parallax", "largest at least " + base::to_text(gates.min_parallax_deg) + " deg", parallax,
         [&](double v) { return v >= gates.min_parallax_deg; });

  io::Json area = io::Json::object();
  io::Json facets = io::Json::object();
  for (std::size_t v = 0; v < coverage::kVerdicts; ++v) {
    const std::string name(coverage::name_of(static_cast<Verdict>(v)));
    area.set(name, audit.area_m2[v]);
    facets.set(name, audit.facets[v]);
  }
  figures.summary = io::Json::object({{"facets", mesh.triangles.size()},
                                      {"facets_skipped", m.skipped},
                                      {"area_m2", o.total_m2},
                                      {"completeness", audit.completeness()},
                                      {"area_m2_by_verdict", std::move(area)},
                                      {"facets_by_verdict", std::move(facets)},
                                      {"gates", std::move(gate_list)},
                                      {"views", percentiles(o, views)},
                                      {"gsd_best_mm", gsd_spread},
                                      {"incidence_best_deg", percentiles(o, best)},
                                      {"incidence_median_deg", percentiles(o, column(m.incidence_median_deg))},
                                      {"parallax_deg", percentiles(o, parallax)},
                                      {"parallax_second_deg", percentiles(o, column(m.parallax_second_deg))},
                                      {"azimuth_bins", percentiles(o, azimuths)},
                                      {"sigma_max_mm", percentiles(o, sigma)},
                                      {"sigma_z_mm", percentiles(o, column(m.sigma_z_mm))},
                                      {"overlap", percentiles(o, overlap)},
                                      {"sides", sides(mesh, o, audit)},
                                      {"sight_lines", static_cast<std::int64_t>(m.rays)}});
  return figures;
}

}  // namespace cairn::pipeline
