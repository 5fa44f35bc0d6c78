#include "fragility/assessment.hpp"

#include <array>
#include <cmath>

#include "base/angle.hpp"
#include "fragility/contact_bounds.hpp"
#include "fragility/photo_view.hpp"
#include "fragility/rolling.hpp"
#include "fragility/tipping_record.hpp"

namespace cairn::fragility {

void FragilityOptions::visit(base::OptionVisitor& visitor) {
  visitor.real("density", density_kg_m3, 100.0, 10000.0, "rock density [kg/m3]; the default is marked assumed");
  visitor.real("friction", friction, 0.01, 10.0, "friction coefficient between rock and pedestal");
  visitor.real("contact-band", contact_band, 0.0, 0.5, "without a contact: share of the height taken as the base");
  visitor.real("plumb-tolerance-m", plumb_tolerance_m, 0.0, 1.0,
               "plumb points closer to the border of the contact count as outside");
  visitor.real("pedestal-curvature", pedestal_curvature, -100.0, 100.0,
               "curvature of the pedestal under a single contact point [1/m], convex > 0");
  grade.visit(visitor);
  monte_carlo.visit(visitor);
}

std::vector<geometry::Vec3> contact_band(const geometry::TriangleMesh& mesh, double band) {
  std::vector<geometry::Vec3> contacts;
  if (mesh.vertices.empty()) return contacts;
  const auto box = mesh.bounds();
  const double limit = box.min.z() + band * box.size().z();
  for (const auto& v : mesh.vertices)
    if (v.z() <= limit) contacts.push_back(v);
  return contacts;
}

namespace {

// A contact counted as closed this far above the seat, m (fragility.md section 7.1).
constexpr std::array<double, 3> kGaps{0.01, 0.02, 0.05};

void describe_contact(survey::Tipping& tip, const Subject& s) {
  const auto plane = contact_plane(s.contact);
  tip.contact_assumed = s.evidence.contact_assumed;
  tip.contact_observed_share = s.evidence.contact_observed_share;
  tip.contact_pads = static_cast<std::int64_t>(pads_of(s.contact).size());
  tip.contact_slope_rad = plane.slope;
  tip.contact_aspect_deg = plane.aspect_deg;
}

void roll(survey::Tipping& tip, const Subject& s, const FragilityOptions& options) {
  if (s.mesh == nullptr || s.contact.empty()) return;
  tip.rolling = rolling_rule(*s.mesh, s.mass, s.contact.front().position, options.pedestal_curvature);
  if (tip.rolling) tip.reasons.emplace_back(tip.rolling->stable ? "rolls_back" : "rolls_away");
}

void fill_tipping(survey::Tipping& tip, const TippingResult& detail, const Subject& s,
                  const FragilityOptions& options) {
  for (const auto& edge : detail.edges) tip.edges.push_back(record_of(edge));
  tip.critical = tip.edges[*detail.critical];
  tip.a_qs_g_by_azimuth = detail.a_qs_g_by_azimuth;
  tip.alpha_point_rad = detail.alpha_point;
  tip.a_qs_min_g = detail.a_qs_min_g;
  tip.a_qs_min_azimuth_deg = detail.a_qs_min_azimuth_deg;
  tip.friction = options.friction;
  tip.slides_first = std::tan(tip.critical->alpha_rad) > options.friction;
  if (tip.slides_first) tip.reasons.emplace_back("slides_first");
  auto bounds = contact_bounds(s.mass, s.contact, options.monte_carlo.bearing_inset_max, options.plumb_tolerance_m);
  tip.inner = std::move(bounds.inner);
  tip.outer = std::move(bounds.outer);
  tip.without_pad = without_each_pad(s.mass, s.contact, options.plumb_tolerance_m);
  if (s.mesh == nullptr) return;
  tip.gaps = by_gap(s.mass, *s.mesh, s.contact, kGaps, options.plumb_tolerance_m);
  tip.photo_views = photo_views(*s.mesh, positions_of(s.contact));
}

void fill_uncertainty(Assessment& result, const Subject& s, const FragilityOptions& options,
                      const std::function<base::Random(std::uint64_t)>& random) {
  auto& tip = result.tipping;
  MonteCarloInput input;
  input.mesh = s.mesh;
  input.mass = s.mass;
  input.seen = s.seen;
  input.unseen_area_fraction = s.evidence.unseen_area_fraction.value_or(0.0);
  input.contact = s.contact;
  input.point_spacing_m = s.evidence.point_spacing_m;
  input.noise_m = s.noise_m;
  input.cap_height_sigma_m = s.cap_height_sigma_m;
  input.density_kg_m3 = s.density_kg_m3;
  input.plumb_tolerance_m = options.plumb_tolerance_m;
  input.friction = options.friction;
  std::vector<double> azimuths;
  for (const auto& edge : tip.edges) azimuths.push_back(edge.azimuth_deg);
  auto drawn = tipping_draws(input, options.monte_carlo, random, azimuths, tip.critical->azimuth_deg);
  for (std::size_t e = 0; e < tip.edges.size(); ++e) tip.edges[e].critical_share = drawn.critical_share[e];
  tip.critical->critical_share = tip.edges[*result.detail.critical].critical_share;
  constexpr double kOftenStanding = 0.95;
  if (static_cast<double>(drawn.summary.standing) < kOftenStanding * static_cast<double>(drawn.summary.draws))
    tip.reasons.emplace_back("equilibrium_uncertain");
  tip.uncertainty = std::move(drawn.summary);
  result.draws = std::move(drawn.draws);
}

}  // namespace

Assessment assess(const Subject& subject, const FragilityOptions& options,
                  const std::function<base::Random(std::uint64_t)>& random) {
  Assessment result;
  auto& tip = result.tipping;
  auto detail = tipping(subject.mass, positions_of(subject.contact), options.plumb_tolerance_m);
  auto grading = grade(subject.evidence, options.grade);
  describe_contact(tip, subject);
  tip.contact = detail.support;
  tip.grade = grading.grade;
  tip.reasons = std::move(grading.reasons);
  if (detail.equilibrium != Equilibrium::stable) {
    tip.grade = survey::Grade::not_measurable;
    tip.reasons.emplace_back(reason_of(detail.equilibrium));
    if (detail.equilibrium == Equilibrium::point_contact) roll(tip, subject, options);
  }
  if (tip.grade == survey::Grade::not_measurable) {
    result.detail.equilibrium = detail.equilibrium;
    result.detail.support = std::move(detail.support);
    result.detail.plumb_margin = detail.plumb_margin;
    return result;
  }
  fill_tipping(tip, detail, subject, options);
  result.detail = std::move(detail);
  if (options.monte_carlo.draws > 0) fill_uncertainty(result, subject, options, random);
  return result;
}

}  // namespace cairn::fragility
