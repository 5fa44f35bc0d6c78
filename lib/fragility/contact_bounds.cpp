#include "fragility/contact_bounds.hpp"

#include <algorithm>
#include <limits>

#include "base/number_text.hpp"
#include "fragility/tipping.hpp"
#include "fragility/tipping_record.hpp"

namespace cairn::fragility {
namespace {

using geometry::Vec2;
using geometry::Vec3;

survey::TippingBound bound(const geometry::MassProperties& mass, std::string_view name, const std::vector<Vec3>& points,
                           double tolerance) {
  survey::TippingBound out;
  out.contact = name;
  const auto result = tipping(mass, points, tolerance);
  if (result.equilibrium != Equilibrium::stable) {
    out.reason = reason_of(result.equilibrium);
    return out;
  }
  out.critical = record_of(result.edges[*result.critical]);
  out.a_qs_g_by_azimuth = result.a_qs_g_by_azimuth;
  return out;
}

survey::TippingVariant variant(const geometry::MassProperties& mass, std::string name, double value,
                               const std::vector<Vec3>& points, double tolerance) {
  survey::TippingVariant out;
  out.name = std::move(name);
  out.value = value;
  const auto result = tipping(mass, points, tolerance, Azimuths::none);
  if (result.equilibrium != Equilibrium::stable) {
    out.reason = reason_of(result.equilibrium);
    return out;
  }
  out.alpha_rad = result.edges[*result.critical].alpha;
  out.azimuth_deg = result.edges[*result.critical].azimuth_deg;
  return out;
}

// Height of the seat at a plan position: that of the nearest vertex of a densified line.
double seat_height(const std::vector<ContactVertex>& line, const Vec2& at) {
  double best = std::numeric_limits<double>::infinity(), z = 0.0;
  for (const auto& v : line) {
    const double d = (v.position.head<2>() - at).squaredNorm();
    if (d < best) best = d, z = v.position.z();
  }
  return z;
}

}  // namespace

std::vector<Vec3> inset_contact(const std::vector<ContactVertex>& contact, double inset) {
  std::vector<Vec3> points;
  points.reserve(contact.size());
  for (const auto& pad : pads_of(contact)) {
    const Vec3 middle = middle_of(contact, pad);
    for (std::size_t i = pad.first; i < pad.last; ++i)
      points.push_back(middle + (1.0 - inset) * (contact[i].position - middle));
  }
  return points;
}

ContactBounds contact_bounds(const geometry::MassProperties& mass, const std::vector<ContactVertex>& contact,
                             double inset, double tolerance) {
  ContactBounds bounds;
  bounds.outer = bound(mass, "rim", positions_of(contact), tolerance);
  const auto whole = inset_contact(contact, inset);
  std::vector<Vec3> seen;
  for (std::size_t i = 0; i < contact.size(); ++i)
    if (contact[i].observed) seen.push_back(whole[i]);
  constexpr std::size_t kLeast = 3;
  if (seen.size() < kLeast) {
    bounds.inner.contact = "seen";
    bounds.inner.reason = "no_contact_seen";
  } else {
    bounds.inner = bound(mass, "seen", seen, tolerance);
  }
  return bounds;
}

std::vector<survey::TippingVariant> without_each_pad(const geometry::MassProperties& mass,
                                                     const std::vector<ContactVertex>& contact, double tolerance) {
  std::vector<survey::TippingVariant> out;
  const auto pads = pads_of(contact);
  if (pads.size() < 2) return out;
  for (const auto& pad : pads) {
    std::vector<Vec3> rest;
    for (std::size_t i = 0; i < contact.size(); ++i)
      if (i < pad.first || i >= pad.last) rest.push_back(contact[i].position);
    out.push_back(variant(mass, "pad " + std::to_string(pad.id), static_cast<double>(pad.id), rest, tolerance));
  }
  return out;
}

std::vector<survey::TippingVariant> by_gap(const geometry::MassProperties& mass, const geometry::TriangleMesh& mesh,
                                           const std::vector<ContactVertex>& contact, std::span<const double> gaps,
                                           double tolerance) {
  std::vector<survey::TippingVariant> out;
  if (contact.empty() || gaps.empty()) return out;
  double length = 0.0, most = 0.0;
  for (const auto& pad : pads_of(contact)) {
    double of_pad = 0.0;
    (void)arc_lengths(contact, pad, of_pad);
    length += of_pad;
  }
  for (const double g : gaps) most = std::max(most, g);
  constexpr int kPieces = 200;
  const auto line = densified(contact, std::max(length / kPieces, 1e-6), kPieces);
  double top = line.front().position.z();
  for (const auto& v : line) top = std::max(top, v.position.z());
  // Heights above the seat, of vertices that may lie within the widest gap; the others stand above it.
  const double limit = top + most;
  std::vector<double> above(mesh.vertices.size(), std::numeric_limits<double>::infinity());
  std::vector<bool> known(mesh.vertices.size(), false);
  const auto height = [&](std::uint32_t i) {
    if (!known[i]) {
      known[i] = true;
      const Vec3& v = mesh.vertices[i];
      above[i] = v.z() - seat_height(line, v.head<2>());
    }
    return above[i];
  };
  for (const double gap : gaps) {
    auto points = positions_of(line);
    const auto add = [&](const Vec3& p, double h) { points.emplace_back(p.x(), p.y(), p.z() - h); };
    for (const auto& t : mesh.triangles) {
      if (std::min({mesh.vertices[t[0]].z(), mesh.vertices[t[1]].z(), mesh.vertices[t[2]].z()}) > limit) continue;
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t i = t[k], j = t[(k + 1) % 3];
        const double hi = height(i), hj = height(j);
        if (hi <= gap) add(mesh.vertices[i], hi);
        if ((hi <= gap) == (hj <= gap)) continue;
        const double f = (gap - hi) / (hj - hi);
        add(mesh.vertices[i] + f * (mesh.vertices[j] - mesh.vertices[i]), gap);
      }
    }
    out.push_back(variant(mass, "gap " + base::to_text(gap) + " m", gap, points, tolerance));
  }
  return out;
}

}  // namespace cairn::fragility
