#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <utility>

#include "base/number_text.hpp"
#include "io/glb.hpp"
#include "io/ply.hpp"
#include "pipeline/coverage_products.hpp"
#include "report/palette.hpp"

namespace cairn::pipeline {
namespace {

using coverage::Audit;
using coverage::FacetCoverage;
using Colour = std::array<std::uint8_t, 3>;

constexpr std::size_t kSteps = 32;  // of a continuous metric
constexpr Colour kNoData{160, 160, 160};

Colour ramp(double t) {
  const report::Rgba c = report::cividis(t);
  return {c[0], c[1], c[2]};
}

// Okabe and Ito's colours, told apart by any eye: passed, no_data, out_of_frame, occluded, too_oblique, too_coarse,
// low_parallax.
constexpr std::array<Colour, coverage::kVerdicts> kVerdictColours{
    Colour{0, 158, 115},  kNoData, Colour{0, 0, 0}, Colour{213, 94, 0}, Colour{230, 159, 0}, Colour{86, 180, 233},
    Colour{204, 121, 167}};

struct Scale {
  std::function<Colour(std::size_t facet)> colour;
  std::string key;  // one sentence
};

std::string hex(const Colour& c) {
  return report::css_colour({c[0], c[1], c[2], 255});
}

Scale scale_of(const std::string& metric, const FacetCoverage& m, const Audit& audit) {
  if (metric == "verdict") {
    std::string key = "verdict:";
    for (std::size_t v = 0; v < coverage::kVerdicts; ++v)
      key += " " + hex(kVerdictColours[v]) + " " + std::string(name_of(static_cast<coverage::Verdict>(v)));
    return {[&audit](std::size_t f) { return kVerdictColours[static_cast<std::size_t>(audit.verdicts[f])]; }, key};
  }
  if (metric == "views") {
    constexpr double kMost = 10.0;
    return {
        [&m](std::size_t f) {
          return m.views[f] == 0 ? Colour{213, 94, 0} : ramp(std::min(1.0, static_cast<double>(m.views[f]) / kMost));
        },
        "views: " + hex({213, 94, 0}) + " none, then " + hex(ramp(0.1)) + " one to " + hex(ramp(1.0)) +
            " ten and more"};
  }
  const std::vector<float>& values = metric == "gsd"         ? m.gsd_best_mm
                                     : metric == "incidence" ? m.incidence_best_deg
                                     : metric == "parallax"  ? m.parallax_deg
                                                             : m.sigma_max_mm;
  std::vector<float> known;
  for (const float v : values)
    if (std::isfinite(v)) known.push_back(v);
  std::sort(known.begin(), known.end());
  const auto at = [&known](double share) {
    return known.empty()
               ? 0.0
               : static_cast<double>(known[static_cast<std::size_t>(share * static_cast<double>(known.size() - 1))]);
  };
  const double lo = at(0.02), hi = at(0.98);
  const bool small_is_good = metric != "parallax";
  const auto colour = [=](double t) { return ramp(small_is_good ? 1.0 - t : t); };
  return {[=, &values](std::size_t f) {
            if (!std::isfinite(values[f])) return kNoData;
            const double t = hi > lo ? std::clamp((static_cast<double>(values[f]) - lo) / (hi - lo), 0.0, 1.0) : 0.0;
            return colour(std::round(t * kSteps) / kSteps);
          },
          metric + (metric == "gsd" || metric == "sigma" ? " in mm" : " in deg") + ": " + hex(colour(0.0)) + " " +
              base::to_fixed(lo, 2) + " and less to " + hex(colour(1.0)) + " " + base::to_fixed(hi, 2) + " and more; " +
              hex(kNoData) + " no value"};
}

}  // namespace

const std::vector<std::string>& colour_metrics() {
  static const std::vector<std::string> names = {"none", "verdict", "views", "gsd", "incidence", "parallax", "sigma"};
  return names;
}

void write_coloured_mesh(const std::filesystem::path& folder, const geometry::TriangleMesh& mesh,
                         const FacetCoverage& metrics, const Audit& audit, const std::string& metric) {
  const Scale scale = scale_of(metric, metrics, audit);
  // Facets of one colour share their vertices; where colours meet, vertices are doubled. The copies of a vertex form a
  // chain, by index.
  constexpr std::uint32_t kEnd = 0xFFFFFFFFU;
  std::vector<std::uint32_t> newest(mesh.vertices.size(), kEnd), before;
  geometry::TriangleMesh painted;
  const auto copy_of = [&](std::uint32_t vertex, const Colour& colour) {
    for (std::uint32_t c = newest[vertex]; c != kEnd; c = before[c])
      if (painted.colours[c] == colour) return c;
    const auto made = static_cast<std::uint32_t>(painted.vertices.size());
    painted.vertices.push_back(mesh.vertices[vertex]);
    painted.colours.push_back(colour);
    before.push_back(newest[vertex]);
    newest[vertex] = made;
    return made;
  };
  for (std::size_t f = 0; f < mesh.triangles.size(); ++f) {
    const geometry::Triangle& t = mesh.triangles[f];
    const std::size_t count = mesh.vertices.size();
    if (t[0] >= count || t[1] >= count || t[2] >= count || !mesh.centroid(f).allFinite() ||
        !(mesh.area_vector(f).squaredNorm() > 0.0))
      continue;
    const Colour colour = audit.verdicts[f] == coverage::Verdict::no_data ? kNoData : scale.colour(f);
    painted.triangles.push_back({copy_of(t[0], colour), copy_of(t[1], colour), copy_of(t[2], colour)});
  }
  if (painted.triangles.empty()) return;
  io::write_ply(folder / "coverage.ply", painted,
                {"", {"predicted visibility, local east north up in metres", scale.key}});
  io::GlbWriteOptions glb;
  glb.name = "coverage";
  glb.origin = painted.bounds().centre();
  glb.properties = io::Json::object({{"key", scale.key}});
  glb.normals = false;
  io::write_glb(folder / "coverage.glb", painted, glb);
}

}  // namespace cairn::pipeline
