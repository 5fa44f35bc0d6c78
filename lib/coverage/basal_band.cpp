#include "coverage/basal_band.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "coverage/large_facets.hpp"

namespace cairn::coverage {
namespace {

using geometry::TriangleMesh;
using geometry::Vec2;
using geometry::Vec3;

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t kMostPieces = 2'000'000;

// A short piece of the contact line.
struct LinePiece {
  Vec3 a = Vec3::Zero(), b = Vec3::Zero();
  double passed = 0.0, area = 0.0, unobserved = 0.0;  // of the band that belongs to it, m^2

  [[nodiscard]] double length() const { return (b - a).norm(); }
  [[nodiscard]] double distance(const Vec3& p) const {
    const Vec3 d = b - a;
    const double n = d.squaredNorm();
    const double t = n > 0.0 ? std::clamp((p - a).dot(d) / n, 0.0, 1.0) : 0.0;
    return (p - a - t * d).norm();
  }
  [[nodiscard]] bool seen() const { return area > 0.0 && passed >= 0.5 * area; }
};

std::size_t sector_of(const Vec2& axis, const Vec2& p) {
  const Vec2 d = p - axis;
  double turn = std::atan2(d.x(), d.y()) / (2.0 * std::numbers::pi);
  if (turn < 0.0) turn += 1.0;
  return std::min(static_cast<std::size_t>(turn * static_cast<double>(kSectors)), kSectors - 1);
}

// The line cut into pieces of about a kSectors-th of its length; each of its edges gives at least one.
std::vector<LinePiece> line_pieces(const survey::Contact& contact) {
  std::vector<std::pair<Vec3, Vec3>> edges;
  for (std::size_t i = 0; i < contact.size();) {
    std::size_t end = i;
    while (end < contact.size() && contact[end].pad == contact[i].pad) ++end;
    for (std::size_t k = i; k + 1 < end; ++k) edges.emplace_back(contact[k].position, contact[k + 1].position);
    if (contact[i].closed && end - i > 2) edges.emplace_back(contact[end - 1].position, contact[i].position);
    i = end;
  }
  double length = 0.0;
  for (const auto& [a, b] : edges) length += (b - a).norm();
  std::vector<LinePiece> pieces;
  for (const auto& [a, b] : edges) {
    const double n = std::max(1.0, std::round(static_cast<double>(kSectors) * (b - a).norm() / length));
    for (double k = 0.0; k < n; k += 1.0)
      pieces.push_back({a + (b - a) * (k / n), a + (b - a) * ((k + 1.0) / n), 0.0, 0.0, 0.0});
  }
  return pieces;
}

// Facets that may reach into the band, and the flags of those.
struct NearFacets {
  TriangleMesh mesh;
  std::vector<std::uint8_t> observed;
};

NearFacets near_facets(const TriangleMesh& surface, std::span<const std::uint8_t> observed,
                       const std::vector<LinePiece>& line, double band) {
  geometry::Box3 box;
  for (const LinePiece& piece : line) {
    box.extend(piece.a);
    box.extend(piece.b);
  }
  const Vec3 lo = box.min - Vec3::Constant(band), hi = box.max + Vec3::Constant(band);
  NearFacets result;
  for (std::size_t f = 0; f < surface.triangles.size(); ++f) {
    const geometry::Triangle& t = surface.triangles[f];
    const std::size_t count = surface.vertices.size();
    if (t[0] >= count || t[1] >= count || t[2] >= count) continue;
    geometry::Box3 own;
    for (const std::uint32_t v : t) own.extend(surface.vertices[v]);
    if (!((own.max.array() >= lo.array()).all() && (own.min.array() <= hi.array()).all())) continue;
    const auto first = static_cast<std::uint32_t>(result.mesh.vertices.size());
    for (const std::uint32_t v : t) result.mesh.vertices.push_back(surface.vertices[v]);
    result.mesh.triangles.push_back({first, first + 1, first + 2});
    result.observed.push_back(observed.empty() || observed[f] != 0 ? 1 : 0);
  }
  return result;
}

double weighted_median(std::vector<std::pair<double, double>> values) {
  if (values.empty()) return kNone;
  std::sort(values.begin(), values.end());
  double total = 0.0, sum = 0.0;
  for (const auto& [value, weight] : values) total += weight;
  for (const auto& [value, weight] : values)
    if ((sum += weight) >= 0.5 * total) return value;
  return values.back().first;
}

GateOptions basal_gates(const GateOptions& gates, const BasalOptions& options) {
  GateOptions result = gates;
  result.max_gsd_mm = options.max_gsd_mm;
  return result;
}

}  // namespace

std::optional<BasalAudit> audit_contact(const TriangleMesh& surface, std::span<const std::uint8_t> observed,
                                        const visibility::Scene& scene, const survey::Contact& contact,
                                        const Vec2& axis, const ViewSet& views, const CoverageOptions& visibility,
                                        const GateOptions& gates, const BasalOptions& options, base::RunContext& ctx) {
  std::vector<LinePiece> line = line_pieces(contact);
  if (line.empty()) return std::nullopt;
  const NearFacets near = near_facets(surface, observed, line, options.band_m);
  const CutMesh fine = cut_large_facets(near.mesh, 0.25 * options.band_m, kMostPieces);
  // Only what lies in the band, each facet with the piece of the line that it is nearest to.
  TriangleMesh band;
  band.vertices = fine.mesh.vertices;
  std::vector<std::size_t> piece_of;
  std::vector<std::uint8_t> seen_surface;
  for (std::size_t f = 0; f < fine.mesh.triangles.size(); ++f) {
    const Vec3 c = fine.mesh.centroid(f);
    if (!c.allFinite()) continue;
    double least = std::numeric_limits<double>::infinity();
    std::size_t nearest = 0;
    for (std::size_t k = 0; k < line.size(); ++k) {
      const double d = line[k].distance(c);
      if (d >= least) continue;
      least = d;
      nearest = k;
    }
    if (least > options.band_m) continue;
    band.triangles.push_back(fine.mesh.triangles[f]);
    piece_of.push_back(nearest);
    seen_surface.push_back(near.observed[fine.parent[f]]);
  }
  if (band.triangles.empty()) return std::nullopt;

  CoverageOptions with_metrics = visibility;
  with_metrics.metrics = true;
  const FacetCoverage metrics = coverage(band, scene, views, with_metrics, ctx);
  const GateOptions own = basal_gates(gates, options);
  std::vector<std::pair<double, double>> gsd;
  for (std::size_t f = 0; f < band.triangles.size(); ++f) {
    const double area = band.area_vector(f).norm();
    LinePiece& piece = line[piece_of[f]];
    if (seen_surface[f] == 0) {
      piece.unobserved += area;
      continue;
    }
    piece.area += area;
    if (judge(metrics, f, own) == Verdict::passed) piece.passed += area;
    if (metrics.views[f] > 0) gsd.emplace_back(static_cast<double>(metrics.gsd_best_mm[f]), area);
  }
  BasalAudit result;
  result.contact_known = true;
  result.gsd_best_mm = weighted_median(std::move(gsd));
  std::array<double, kSectors> length{}, seen{};
  double seen_length = 0.0, no_data = 0.0;
  for (const LinePiece& piece : line) {
    const std::size_t s = sector_of(axis, (0.5 * (piece.a + piece.b)).head<2>());
    length[s] += piece.length();
    result.perimeter_m += piece.length();
    if (piece.unobserved >= piece.area) no_data += piece.length();
    if (!piece.seen() || piece.unobserved > piece.area) continue;
    seen[s] += piece.length();
    seen_length += piece.length();
  }
  for (std::size_t s = 0; s < kSectors; ++s) result.seen_by_azimuth[s] = length[s] > 0.0 ? seen[s] / length[s] : kNone;
  if (result.perimeter_m > 0.0) {
    result.seen_share = seen_length / result.perimeter_m;
    result.no_data_share = no_data / result.perimeter_m;
  }
  return result;
}

BasalAudit audit_lowest_part(const geometry::VerticalCylinder& cylinder, const FacetCoverage& metrics,
                             std::size_t first, const std::array<double, kSectors>& foot, const GateOptions& gates,
                             const BasalOptions& options) {
  const GateOptions own = basal_gates(gates, options);
  const double row_height = cylinder.height() / static_cast<double>(kWallRows);
  BasalAudit result;
  result.perimeter_m = 2.0 * std::numbers::pi * cylinder.radius;
  std::vector<std::pair<double, double>> gsd;
  double seen = 0.0;
  for (std::size_t s = 0; s < kSectors; ++s) {
    std::size_t rows = 0, passed = 0;
    for (std::size_t row = 0; row < kWallRows; ++row) {
      const double up = (static_cast<double>(row) + 0.5) * row_height;
      if (up < foot[s] || up > foot[s] + options.band_of_height * cylinder.height()) continue;
      for (std::size_t k = 0; k < 2; ++k) {
        const std::size_t facet = first + 2 * (row * kSectors + s) + k;
        ++rows;
        passed += judge(metrics, facet, own) == Verdict::passed ? 1U : 0U;
        if (metrics.views[facet] > 0) gsd.emplace_back(static_cast<double>(metrics.gsd_best_mm[facet]), 1.0);
      }
    }
    result.seen_by_azimuth[s] = rows > 0 && 2 * passed >= rows ? 1.0 : 0.0;
    seen += result.seen_by_azimuth[s];
  }
  result.seen_share = seen / static_cast<double>(kSectors);
  result.gsd_best_mm = weighted_median(std::move(gsd));
  return result;
}

}  // namespace cairn::coverage
