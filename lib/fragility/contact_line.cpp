#include "fragility/contact_line.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <tuple>

#include "base/angle.hpp"

namespace cairn::fragility {

void sort_contact(std::vector<ContactVertex>& contact) {
  std::stable_sort(contact.begin(), contact.end(), [](const ContactVertex& a, const ContactVertex& b) {
    return std::tie(a.pad, a.order) < std::tie(b.pad, b.order);
  });
}

double observed_share(const std::vector<ContactVertex>& contact) {
  double whole = 0.0, seen = 0.0;
  const auto add = [&](const ContactVertex& a, const ContactVertex& b) {
    const double length = (a.position - b.position).norm();
    whole += length;
    if (a.observed && b.observed) seen += length;
  };
  for (std::size_t first = 0; first < contact.size();) {
    std::size_t last = first;
    while (last + 1 < contact.size() && contact[last + 1].pad == contact[first].pad) {
      add(contact[last], contact[last + 1]);
      ++last;
    }
    if (contact[last].closed && last > first + 1) add(contact[last], contact[first]);
    first = last + 1;
  }
  if (whole > 0.0) return seen / whole;
  return !contact.empty() && contact.front().observed ? 1.0 : 0.0;
}

std::size_t outside_count(const std::vector<ContactVertex>& contact, const geometry::Box3& box, double margin) {
  return static_cast<std::size_t>(std::count_if(contact.begin(), contact.end(), [&](const ContactVertex& v) {
    const geometry::Vec3 low = v.position - box.min, high = box.max - v.position;
    return !(std::min(low.minCoeff(), high.minCoeff()) >= -margin);
  }));
}

std::vector<Pad> pads_of(const std::vector<ContactVertex>& contact) {
  std::vector<Pad> pads;
  for (std::size_t i = 0; i < contact.size(); ++i) {
    if (pads.empty() || contact[i].pad != pads.back().id) pads.push_back({contact[i].pad, i, i});
    pads.back().last = i + 1;
  }
  return pads;
}

geometry::Vec3 middle_of(const std::vector<ContactVertex>& contact, const Pad& pad) {
  geometry::Vec3 sum = geometry::Vec3::Zero(), plain = geometry::Vec3::Zero();
  double weight = 0.0;
  for (std::size_t i = pad.first; i < pad.last; ++i) {
    plain += contact[i].position;
    const bool end = i + 1 == pad.last;
    if (end && !(contact[i].closed && pad.last - pad.first > 2)) continue;
    const auto& next = contact[end ? pad.first : i + 1].position;
    const double length = (next - contact[i].position).norm();
    sum += 0.5 * length * (next + contact[i].position);
    weight += length;
  }
  return weight > 0.0 ? geometry::Vec3(sum / weight)
                      : geometry::Vec3(plain / static_cast<double>(pad.last - pad.first));
}

std::vector<double> arc_lengths(const std::vector<ContactVertex>& contact, const Pad& pad, double& length) {
  std::vector<double> at(pad.last - pad.first, 0.0);
  for (std::size_t k = 1; k < at.size(); ++k)
    at[k] = at[k - 1] + (contact[pad.first + k].position - contact[pad.first + k - 1].position).norm();
  length = at.empty() ? 0.0 : at.back();
  if (at.size() > 2 && contact[pad.last - 1].closed)
    length += (contact[pad.first].position - contact[pad.last - 1].position).norm();
  return at;
}

std::vector<ContactVertex> densified(const std::vector<ContactVertex>& contact, double step, std::size_t limit) {
  std::vector<ContactVertex> out;
  for (const auto& pad : pads_of(contact)) {
    double length = 0.0;
    const auto at = arc_lengths(contact, pad, length);
    const double wide = std::max(step, length / static_cast<double>(std::max<std::size_t>(limit, 3)));
    std::int64_t order = 0;
    double since = wide;
    const std::size_t count = pad.last - pad.first;
    for (std::size_t k = 0; k < count; ++k) {
      const auto& a = contact[pad.first + k];
      // A line that is finer than the step keeps only vertices a step apart.
      if (since >= wide * (1.0 - 1e-9) || count <= limit) {
        out.push_back(a);
        out.back().order = order++;
        since = 0.0;
      }
      const bool end = k + 1 == count;
      if (end && !(a.closed && count > 2)) continue;
      const auto& b = contact[end ? pad.first : pad.first + k + 1];
      const double side = (b.position - a.position).norm();
      const auto pieces = static_cast<int>(std::ceil(side / wide - 1e-9));
      for (int p = 1; p < pieces; ++p) {
        const double f = static_cast<double>(p) / pieces;
        ContactVertex v = a;
        v.order = order++;
        v.position = (1.0 - f) * a.position + f * b.position;
        v.sigma_m = (1.0 - f) * a.sigma_m + f * b.sigma_m;
        v.observed = a.observed && b.observed;
        out.push_back(v);
      }
      since = pieces > 1 ? wide : since + side;
    }
  }
  return out;
}

ContactPlane contact_plane(const std::vector<ContactVertex>& contact) {
  ContactPlane plane;
  if (contact.empty()) return plane;
  for (const auto& v : contact) plane.centre += v.position;
  plane.centre /= static_cast<double>(contact.size());
  geometry::Mat2 normal = geometry::Mat2::Zero();
  geometry::Vec2 right = geometry::Vec2::Zero();
  for (const auto& v : contact) {
    const geometry::Vec3 d = v.position - plane.centre;
    const geometry::Vec2 xy = d.head<2>();
    normal += xy * xy.transpose();
    right += xy * d.z();
  }
  constexpr double kDegenerate = 1e-9;  // of the squared trace: points on a line in plan fix no plane
  if (std::abs(normal.determinant()) <= kDegenerate * normal.trace() * normal.trace()) return plane;
  plane.gradient = normal.inverse() * right;
  plane.slope = std::atan(plane.gradient.norm());
  constexpr double kLevel = 1e-12;
  if (plane.slope > kLevel) plane.aspect_deg = base::azimuth_deg(-plane.gradient.x(), -plane.gradient.y());
  return plane;
}

std::vector<geometry::Vec3> positions_of(const std::vector<ContactVertex>& contact) {
  std::vector<geometry::Vec3> points;
  points.reserve(contact.size());
  for (const auto& v : contact) points.push_back(v.position);
  return points;
}

}  // namespace cairn::fragility
