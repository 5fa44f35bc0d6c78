#include "coverage/target_audit.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

namespace cairn::coverage {
namespace {

using geometry::TriangleMesh;
using geometry::Vec2;
using geometry::Vec3;
using geometry::VerticalCylinder;

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

std::optional<base::Reject> unusable(const TargetBody& body) {
  const VerticalCylinder& c = body.cylinder;
  const std::string record = "target " + std::to_string(body.id.value);
  if (!c.axis.allFinite() || !std::isfinite(c.bottom) || !std::isfinite(c.top) || !std::isfinite(c.radius))
    return base::Reject{record, "cylinder_not_finite", "a number of its cylinder is not finite"};
  if (!(c.height() > 0.0))
    return base::Reject{record, "cylinder_without_height", "its cylinder has no height, so it has no wall to look at"};
  if (!(c.radius > 0.0))
    return base::Reject{record, "cylinder_without_radius", "its cylinder has no radius, so it has no wall to look at"};
  return std::nullopt;
}

// Height above the cylinder's bottom at which each sector's wall comes out of the ground: that of the surface just
// outside, seen from above. 0 where there is none, or something stands there.
std::array<double, kSectors> foot_of(const VerticalCylinder& c, const visibility::Scene& scene, double clearance) {
  constexpr double kSomethingElse = 0.5;  // of the height: no ground any more
  constexpr double kAbove = 1000.0;       // m; higher than anything that stands on the ground
  std::vector<geometry::Ray> rays;
  for (std::size_t s = 0; s < kSectors; ++s) {
    const Vec2 p = sector_point(c.axis, c.radius + clearance, s);
    rays.push_back({Vec3(p.x(), p.y(), c.top + kAbove), -Vec3::UnitZ()});
  }
  const auto hits = scene.cast(rays);
  std::array<double, kSectors> foot{};
  for (std::size_t s = 0; s < kSectors; ++s) {
    const double up = hits[s].hit() ? c.top + kAbove - hits[s].distance - c.bottom : 0.0;
    foot[s] = up < kSomethingElse * c.height() ? std::max(0.0, up) : 0.0;
  }
  return foot;
}

// Area-weighted quantile; values that are not finite count as the greatest.
double quantile(std::vector<std::pair<double, double>> values, double share) {
  for (auto& [value, weight] : values)
    if (!std::isfinite(value)) value = std::numeric_limits<double>::infinity();
  std::sort(values.begin(), values.end());
  double total = 0.0, sum = 0.0;
  for (const auto& [value, weight] : values) total += weight;
  for (const auto& [value, weight] : values)
    if ((sum += weight) >= share * total) return std::isfinite(value) ? value : kNone;
  return kNone;
}

// One target's facets of the joint mesh.
class TargetJudge {
 public:
  TargetJudge(TargetsAudit& all, std::size_t first, const std::array<double, kSectors>& foot, const GateOptions& gates)
      : all_(all), first_(first), foot_(foot), gates_(gates) {}

  void run(TargetAudit& target) {
    std::array<double, kSectors> passed{}, area{};
    std::uint16_t azimuths = 0;
    std::vector<std::pair<double, double>> sigma;
    for (std::size_t i = 0; i < kCylinderFacets; ++i) {
      const std::size_t f = first_ + i;
      const bool wall = i < kWallFacets;
      const double a = all_.mesh.area_vector(f).norm();
      const std::size_t sector = wall ? wall_place(i).sector : 0;
      if (wall && all_.mesh.centroid(f).z() - target.cylinder.bottom < foot_[sector]) {
        target.wall.buried_m2 += a;
        all_.verdicts[f] = Verdict::no_data;
        continue;
      }
      PartAudit& part = wall ? target.wall : target.top;
      const Verdict verdict = judge(all_.metrics, f, gates_);
      all_.verdicts[f] = verdict;
      part.area_m2 += a;
      part.area_by_verdict[static_cast<std::size_t>(verdict)] += a;
      azimuths = static_cast<std::uint16_t>(azimuths | all_.metrics.azimuths[f]);
      sigma.emplace_back(static_cast<double>(all_.metrics.sigma_max_mm[f]), a);
      if (!wall) continue;
      area[sector] += a;
      passed[sector] += verdict == Verdict::passed ? a : 0.0;
    }
    for (std::size_t s = 0; s < kSectors; ++s) target.wall_by_azimuth[s] = area[s] > 0.0 ? passed[s] / area[s] : kNone;
    target.azimuth_bins = azimuth_bins(azimuths);
    target.sigma_95_mm = quantile(std::move(sigma), 0.95);
    describe(target.wall, 0, kWallFacets);
    describe(target.top, kWallFacets, kCylinderFacets);
  }

 private:
  void describe(PartAudit& part, std::size_t begin, std::size_t end) {
    std::vector<std::pair<double, double>> views, gsd, incidence;
    for (std::size_t f = first_ + begin; f < first_ + end; ++f) {
      if (all_.verdicts[f] == Verdict::no_data) continue;
      const double a = all_.mesh.area_vector(f).norm();
      views.emplace_back(static_cast<double>(all_.metrics.views[f]), a);
      gsd.emplace_back(static_cast<double>(all_.metrics.gsd_best_mm[f]), a);
      incidence.emplace_back(static_cast<double>(all_.metrics.incidence_best_deg[f]), a);
    }
    part.views_median = quantile(std::move(views), 0.5);
    part.gsd_median_mm = quantile(std::move(gsd), 0.5);
    part.incidence_median_deg = quantile(std::move(incidence), 0.5);
  }

  TargetsAudit& all_;
  std::size_t first_;
  const std::array<double, kSectors>& foot_;
  const GateOptions& gates_;
};

void decide(TargetAudit& target, const TargetOptions& options) {
  constexpr double kMillimetres = 1000.0;
  if (target.wall.completeness() < options.min_completeness) target.reasons.emplace_back("wall");
  if (target.top.completeness() < options.min_completeness) target.reasons.emplace_back("top");
  if (target.basal.seen_share < options.min_perimeter) target.reasons.emplace_back("basal_band");
  if (target.azimuth_bins < options.min_azimuth_bins) target.reasons.emplace_back("azimuths");
  const double most = kMillimetres * options.max_sigma_of_width * 2.0 * target.cylinder.radius;
  if (options.max_sigma_of_width > 0.0 && !(target.sigma_95_mm <= most)) target.reasons.emplace_back("sigma");
  target.passed = target.reasons.empty();
}

}  // namespace

TriangleMesh target_occluders(const TriangleMesh& surface, const std::vector<TargetBody>& bodies,
                              const TriangleMesh& cylinders, double clearance) {
  constexpr double kFoot = 0.15;  // of the height: below that the surface is the ground
  std::vector<const VerticalCylinder*> by_east;
  double reach = 0.0;
  for (const TargetBody& body : bodies) {
    by_east.push_back(&body.cylinder);
    reach = std::max(reach, body.cylinder.radius + clearance);
  }
  std::stable_sort(by_east.begin(), by_east.end(),
                   [](const auto* a, const auto* b) { return a->axis.x() < b->axis.x(); });
  TriangleMesh result;
  result.vertices = surface.vertices;
  for (std::size_t f = 0; f < surface.triangles.size(); ++f) {
    const geometry::Triangle& t = surface.triangles[f];
    const std::size_t count = surface.vertices.size();
    if (t[0] >= count || t[1] >= count || t[2] >= count) continue;
    const Vec3 c = surface.centroid(f);
    const double top = std::max({surface.vertices[t[0]].z(), surface.vertices[t[1]].z(), surface.vertices[t[2]].z()});
    auto near = std::lower_bound(by_east.begin(), by_east.end(), c.x() - reach,
                                 [](const auto* cylinder, double x) { return cylinder->axis.x() < x; });
    bool part = false;
    for (; !part && near != by_east.end() && (*near)->axis.x() <= c.x() + reach; ++near) {
      const VerticalCylinder& body = **near;
      part = (c.head<2>() - body.axis).norm() <= body.radius + clearance && top > body.bottom + kFoot * body.height() &&
             c.z() <= body.top + clearance;
    }
    if (!part) result.triangles.push_back(t);
  }
  const auto offset = static_cast<std::uint32_t>(result.vertices.size());
  result.vertices.insert(result.vertices.end(), cylinders.vertices.begin(), cylinders.vertices.end());
  for (const geometry::Triangle& t : cylinders.triangles)
    result.triangles.push_back({t[0] + offset, t[1] + offset, t[2] + offset});
  return result;
}

TargetsAudit audit_targets(const TriangleMesh& surface, std::span<const std::uint8_t> observed,
                           const visibility::Scene& scene, const std::vector<TargetBody>& bodies, const ViewSet& views,
                           const CoverageOptions& visibility, const GateOptions& gates, const TargetOptions& options,
                           base::RunContext& ctx) {
  TargetOptions checked = options;
  base::validate(base::bind_options(checked), "coverage of targets");
  TargetsAudit result;
  std::vector<TargetBody> usable;
  for (const TargetBody& body : bodies) {
    if (auto reject = unusable(body)) {
      result.rejects.push_back(*std::move(reject));
      continue;
    }
    usable.push_back(body);
    const TriangleMesh own = cylinder_mesh(body.cylinder);
    const auto offset = static_cast<std::uint32_t>(result.mesh.vertices.size());
    result.mesh.vertices.insert(result.mesh.vertices.end(), own.vertices.begin(), own.vertices.end());
    for (const geometry::Triangle& t : own.triangles)
      result.mesh.triangles.push_back({t[0] + offset, t[1] + offset, t[2] + offset});
  }
  if (usable.empty()) return result;

  CoverageOptions with_metrics = visibility;
  with_metrics.metrics = true;
  const visibility::Scene standing(target_occluders(surface, usable, result.mesh, options.clearance_m));
  result.metrics = coverage(result.mesh, standing, views, with_metrics, ctx);
  result.verdicts.assign(result.mesh.triangles.size(), Verdict::no_data);
  for (std::size_t i = 0; i < usable.size(); ++i) {
    ctx.check_stop();
    const TargetBody& body = usable[i];
    TargetAudit target;
    target.id = body.id;
    target.cylinder = body.cylinder;
    GateOptions own = gates;
    constexpr double kMillimetres = 1000.0;
    own.max_gsd_mm = kMillimetres * options.max_gsd_of_height * body.cylinder.height();
    const auto foot = foot_of(body.cylinder, scene, options.clearance_m);
    TargetJudge(result, i * kCylinderFacets, foot, own).run(target);
    std::optional<BasalAudit> basal;
    if (!body.contact.empty()) {
      basal = audit_contact(surface, observed, scene, body.contact, body.cylinder.axis, views, with_metrics, gates,
                            options.basal, ctx);
      if (!basal)
        result.rejects.push_back({"target " + std::to_string(body.id.value), "contact_off_surface",
                                  "no facet of the surface lies near its contact line; its lowest part is taken"});
    }
    target.basal =
        basal ? *basal
              : audit_lowest_part(body.cylinder, result.metrics, i * kCylinderFacets, foot, gates, options.basal);
    decide(target, options);
    result.targets.push_back(std::move(target));
  }
  return result;
}

}  // namespace cairn::coverage
