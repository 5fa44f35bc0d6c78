// Subjects of an assessment made of points and masses.
#pragma once

#include <vector>

#include "fragility/assessment.hpp"

namespace cairn::testing {

inline base::Random draw_random(std::uint64_t k) {
  return base::Random(1, "fragility", k);
}

// One closed pad through the points; observed, sigma not stated.
inline survey::Contact closed_pad(const std::vector<geometry::Vec3>& points, std::int64_t pad = 0) {
  survey::Contact contact;
  for (const auto& p : points) contact.push_back({pad, static_cast<std::int64_t>(contact.size()), p, true, true, 0.0});
  return contact;
}

// Without draws.
inline fragility::Assessment assess_points(const geometry::MassProperties& mass,
                                           const std::vector<geometry::Vec3>& points,
                                           const fragility::Evidence& evidence,
                                           fragility::FragilityOptions options = {}) {
  fragility::Subject subject;
  subject.mass = mass;
  subject.contact = closed_pad(points);
  subject.evidence = evidence;
  options.monte_carlo.draws = 0;
  return fragility::assess(subject, options, draw_random);
}

}  // namespace cairn::testing
