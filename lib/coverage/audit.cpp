#include "coverage/audit.hpp"

#include <cmath>
#include <numeric>
#include <string>

#include "base/error.hpp"
#include "base/parallel.hpp"

namespace cairn::coverage {
Verdict judge(const FacetCoverage& m, std::size_t i, const GateOptions& gates) {
  const auto least = static_cast<std::uint32_t>(gates.min_views);
  if (m.views[i] < least) {
    if (m.in_frame[i] < least) return Verdict::out_of_frame;
    return m.facing[i] < least ? Verdict::too_oblique : Verdict::occluded;
  }
  const float incidence = gates.min_views < 2 ? m.incidence_best_deg[i] : m.incidence_second_deg[i];
  if (!(static_cast<double>(incidence) <= gates.max_incidence_deg)) return Verdict::too_oblique;
  if (gates.max_gsd_mm > 0.0 && !(static_cast<double>(m.gsd_best_mm[i]) <= gates.max_gsd_mm))
    return Verdict::too_coarse;
  // One view has no parallax at all.
  if (gates.min_parallax_deg > 0.0 && !(static_cast<double>(m.parallax_deg[i]) >= gates.min_parallax_deg))
    return Verdict::low_parallax;
  return Verdict::passed;
}

std::string_view name_of(Verdict verdict) {
  constexpr std::array<std::string_view, kVerdicts> kNames = {"passed",      "no_data",    "out_of_frame", "occluded",
                                                              "too_oblique", "too_coarse", "low_parallax"};
  return kNames[static_cast<std::size_t>(verdict)];
}

double Audit::observed_area() const {
  return std::accumulate(area_m2.begin(), area_m2.end(), 0.0) - area(Verdict::no_data);
}

double Audit::completeness() const {
  const double observed = observed_area();
  return observed > 0.0 ? area(Verdict::passed) / observed : 0.0;
}

Audit audit(const geometry::TriangleMesh& mesh, const FacetCoverage& metrics, std::span<const std::uint8_t> observed,
            const GateOptions& gates) {
  GateOptions checked = gates;
  base::validate(base::bind_options(checked), "coverage gates");
  const std::size_t count = mesh.triangles.size();
  if (metrics.views.size() != count || metrics.parallax_deg.size() != count ||
      !(observed.empty() || observed.size() == count))
    throw base::Error(base::ErrorCode::invalid_argument, "the audit needs metrics and flags of every facet")
        .found(std::to_string(metrics.parallax_deg.size()))
        .allowed(std::to_string(count));
  Audit result;
  result.verdicts.resize(count);
  std::vector<double> area(count, 0.0);
  base::parallel_for(count, 8192, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      result.verdicts[i] = !observed.empty() && observed[i] == 0 ? Verdict::no_data : judge(metrics, i, gates);
      const auto& t = mesh.triangles[i];
      const std::size_t vertices = mesh.vertices.size();
      if (t[0] >= vertices || t[1] >= vertices || t[2] >= vertices) continue;
      const double a = mesh.area_vector(i).norm();
      if (std::isfinite(a)) area[i] = a;
    }
  });
  std::vector<double> of_verdict(count);
  for (std::size_t v = 0; v < kVerdicts; ++v) {
    for (std::size_t i = 0; i < count; ++i) {
      const bool mine = static_cast<std::size_t>(result.verdicts[i]) == v && area[i] > 0.0;
      of_verdict[i] = mine ? area[i] : 0.0;
      result.facets[v] += mine ? 1 : 0;
    }
    result.area_m2[v] = base::deterministic_sum(of_verdict);
  }
  return result;
}

}  // namespace cairn::coverage
