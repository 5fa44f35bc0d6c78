#include "fragility/assessment.hpp"

#include <cmath>

namespace cairn::fragility {

void FragilityOptions::visit(base::OptionVisitor& visitor) {
  visitor.real("density", density_kg_m3, 100.0, 10000.0, "rock density [kg/m3]; the default is marked assumed");
  visitor.real("friction", friction, 0.01, 10.0, "friction coefficient between rock and pedestal");
  visitor.real("contact-band", contact_band, 0.0, 0.5, "without a contact: share of the height taken as the base");
  visitor.real("plumb-tolerance-m", plumb_tolerance_m, 0.0, 1.0,
               "plumb points closer to the border of the contact count as outside");
  grade.visit(visitor);
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

Assessment assess(const geometry::MassProperties& mass, std::span<const geometry::Vec3> contacts,
                  const Evidence& evidence, const FragilityOptions& options) {
  Assessment result;
  auto& tip = result.tipping;
  auto detail = tipping(mass, contacts, options.plumb_tolerance_m);
  auto grading = grade(evidence, options.grade);
  tip.contact = detail.support;
  tip.contact_assumed = evidence.contact_assumed;
  tip.grade = grading.grade;
  tip.reasons = std::move(grading.reasons);
  if (detail.equilibrium != Equilibrium::stable) {
    tip.grade = survey::Grade::not_measurable;
    tip.reasons.emplace_back(reason_of(detail.equilibrium));
  }
  if (tip.grade == survey::Grade::not_measurable) {
    result.detail.equilibrium = detail.equilibrium;
    result.detail.support = std::move(detail.support);
    result.detail.plumb_margin = detail.plumb_margin;
    return result;
  }
  const Edge& edge = detail.edges[*detail.critical];
  tip.critical = survey::TippingEdge{edge.azimuth_deg, edge.alpha, edge.r, edge.p, edge.a_qs_g, edge.v_min};
  tip.a_qs_g_by_azimuth = detail.a_qs_g_by_azimuth;
  if (std::tan(edge.alpha) > options.friction) tip.reasons.emplace_back("slides_first");
  result.detail = std::move(detail);
  return result;
}

}  // namespace cairn::fragility
