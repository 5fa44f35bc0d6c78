#include "fragility/contact_line.hpp"

#include <algorithm>
#include <tuple>

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

}  // namespace cairn::fragility
