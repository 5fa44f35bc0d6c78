#include "coverage/gaps.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>
#include <utility>

#include "coverage/facet_edges.hpp"
#include "coverage/patch_outline.hpp"

namespace cairn::coverage {
namespace {

using geometry::TriangleMesh;
using geometry::Vec2;
using geometry::Vec3;

// Smallest index of each facet's patch (union-find; the smaller root wins, so results follow no order).
class Patches {
 public:
  explicit Patches(std::size_t count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), 0U); }
  std::uint32_t find(std::uint32_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void join(std::uint32_t a, std::uint32_t b) {
    a = find(a);
    b = find(b);
    if (a != b) parent_[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::vector<std::uint32_t> parent_;
};

bool sound(const TriangleMesh& mesh, std::size_t facet) {
  const std::size_t count = mesh.vertices.size();
  for (const std::uint32_t v : mesh.triangles[facet])
    if (v >= count || !mesh.vertices[v].allFinite()) return false;
  return mesh.area_vector(facet).squaredNorm() > 0.0;
}

// Facets of each patch, ascending; patches ascending by first facet.
std::vector<std::vector<std::uint32_t>> patches_of(const TriangleMesh& mesh, const std::vector<Verdict>& verdicts) {
  std::vector<std::uint32_t> failing;
  for (std::size_t i = 0; i < verdicts.size(); ++i)
    if (verdicts[i] != Verdict::passed && sound(mesh, i)) failing.push_back(static_cast<std::uint32_t>(i));
  Patches patches(verdicts.size());
  const std::vector<FacetEdge> edges = facet_edges(mesh, failing);
  for (std::size_t i = 0; i < edges.size();) {
    std::size_t j = i + 1;
    // Around an edge facets stand by number: join those of one reason, whichever lie between.
    for (; j < edges.size() && edges[j].same_edge(edges[i]); ++j)
      for (std::size_t k = i; k < j; ++k)
        if (verdicts[edges[k].facet] == verdicts[edges[j].facet]) {
          patches.join(edges[k].facet, edges[j].facet);
          break;
        }
    i = j;
  }
  std::vector<std::pair<std::uint32_t, std::uint32_t>> member;
  member.reserve(failing.size());
  for (const std::uint32_t f : failing) member.emplace_back(patches.find(f), f);
  std::sort(member.begin(), member.end());
  std::vector<std::vector<std::uint32_t>> result;
  for (std::size_t i = 0; i < member.size(); ++i) {
    if (i == 0 || member[i].first != member[i - 1].first) result.emplace_back();
    result.back().push_back(member[i].second);
  }
  return result;
}

std::vector<geometry::Ring> outline(const TriangleMesh& mesh, const std::vector<std::uint32_t>& facets,
                                    const Vec3& area_vector, double area) {
  const double steep = std::cos(80.0 * 3.14159265358979323846 / 180.0);
  bool upright = area_vector.z() > steep * area;
  for (const std::uint32_t f : facets) upright = upright && mesh.area_vector(f).z() > 0.0;
  if (upright) {
    auto rings = patch_outline(mesh, facets);
    if (!rings.empty() && geometry::signed_area(rings.front()) > 0.0) return rings;
  }
  std::vector<Vec2> points;
  for (const std::uint32_t f : facets)
    for (const std::uint32_t v : mesh.triangles[f]) points.emplace_back(mesh.vertices[v].head<2>());
  return {geometry::convex_hull(std::move(points))};
}

survey::CoverageGap describe(const TriangleMesh& mesh, const std::vector<std::uint32_t>& facets, Verdict verdict,
                             const ViewSet& views, const GapOptions& options) {
  survey::CoverageGap gap;
  gap.facets = facets.size();
  gap.reason = name_of(verdict);
  Vec3 area_vector = Vec3::Zero(), weighted = Vec3::Zero();
  for (const std::uint32_t f : facets) {
    const Vec3 a = mesh.area_vector(f);
    gap.area_m2 += a.norm();
    area_vector += a;
    weighted += a.norm() * mesh.centroid(f);
  }
  const Vec3 middle = weighted / gap.area_m2;
  double closest = std::numeric_limits<double>::infinity();
  for (const std::uint32_t f : facets) {
    const double d = (mesh.centroid(f) - middle).squaredNorm();
    if (d >= closest) continue;
    closest = d;
    gap.centre = mesh.centroid(f);
  }
  gap.rings = outline(mesh, facets, area_vector, gap.area_m2);

  std::vector<std::pair<double, std::size_t>> distance;
  for (std::size_t i = 0; i < views.views.size(); ++i)
    distance.emplace_back((views.views[i].T_world_camera.translation - gap.centre).norm(), i);
  std::sort(distance.begin(), distance.end());
  const auto named = std::min(distance.size(), static_cast<std::size_t>(options.nearest_frames));
  for (std::size_t i = 0; i < named; ++i) gap.nearest_frames.push_back(views.views[distance[i].second].frame);
  if (!distance.empty() && area_vector.norm() > 0.0 && area_vector.z() > 0.0) {
    const double range = distance[(distance.size() - 1) / 2].first;
    gap.view = survey::SuggestedView{gap.centre + range * area_vector.normalized(), gap.centre};
  }
  return gap;
}

}  // namespace

std::vector<survey::CoverageGap> find_gaps(const TriangleMesh& mesh, const std::vector<Verdict>& verdicts,
                                           const ViewSet& views, const GapOptions& options) {
  GapOptions checked = options;
  base::validate(base::bind_options(checked), "coverage gaps");
  std::vector<survey::CoverageGap> gaps;
  for (const auto& facets : patches_of(mesh, verdicts)) {
    double area = 0.0;
    for (const std::uint32_t f : facets) area += mesh.area_vector(f).norm();
    if (area < options.min_area_m2 || !(area > 0.0)) continue;
    gaps.push_back(describe(mesh, facets, verdicts[facets.front()], views, options));
  }
  std::stable_sort(gaps.begin(), gaps.end(),
                   [](const survey::CoverageGap& a, const survey::CoverageGap& b) { return a.area_m2 > b.area_m2; });
  for (std::size_t i = 0; i < gaps.size(); ++i) gaps[i].id = survey::GapId(static_cast<std::int64_t>(i));
  return gaps;
}

}  // namespace cairn::coverage
