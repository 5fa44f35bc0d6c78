#include "evaluation/line_distance.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/error.hpp"
#include "base/number_text.hpp"
#include "evaluation/statistics.hpp"

namespace cairn::evaluation {
namespace {

using geometry::Vec3;
using Segments = std::vector<std::pair<Vec3, Vec3>>;

Segments segments_of(const std::vector<Polyline>& lines) {
  Segments segments;
  for (const auto& line : lines) {
    const auto& p = line.points;
    if (p.size() == 1) segments.emplace_back(p[0], p[0]);
    for (std::size_t i = 1; i < p.size(); ++i) segments.emplace_back(p[i - 1], p[i]);
    if (line.closed && p.size() > 2) segments.emplace_back(p.back(), p.front());
  }
  return segments;
}

double distance(const Vec3& p, const Segments& segments) {
  double best = 1e300;
  for (const auto& [a, b] : segments) {
    const Vec3 along = b - a;
    const double length = along.squaredNorm();
    const double t = length > 0.0 ? std::clamp((p - a).dot(along) / length, 0.0, 1.0) : 0.0;
    best = std::min(best, (p - a - t * along).squaredNorm());
  }
  return std::sqrt(best);
}

struct Sampled {
  std::vector<double> distances;
  double mean = 0.0, max = 0.0;
};

// At the middle of equal parts of each segment, weighted by their length.
Sampled sample(const Segments& from, const Segments& to, double step) {
  Sampled result;
  double length = 0.0, sum = 0.0;
  for (const auto& [a, b] : from) {
    const double size = (b - a).norm();
    const auto parts = static_cast<std::size_t>(std::max(1.0, std::ceil(size / step)));
    for (std::size_t k = 0; k < parts; ++k) {
      const double t = (static_cast<double>(k) + 0.5) / static_cast<double>(parts);
      const double d = distance(a + t * (b - a), to);
      result.distances.push_back(d);
      const double weight = from.size() == 1 && size == 0.0 ? 1.0 : size / static_cast<double>(parts);
      sum += weight * d;
      length += weight;
      result.max = std::max(result.max, d);
    }
  }
  if (length > 0.0) result.mean = sum / length;
  return result;
}

}  // namespace

LineDistance line_distance(const std::vector<Polyline>& found, const std::vector<Polyline>& truth, double step) {
  if (!(step > 0.0))
    throw base::Error(base::ErrorCode::invalid_argument, "the step along the line is out of range")
        .found(base::to_text(step))
        .allowed("above 0 m");
  const Segments a = segments_of(found), b = segments_of(truth);
  LineDistance result;
  if (a.empty() || b.empty()) return result;
  const Sampled there = sample(a, b, step), back = sample(b, a, step);
  result.mean = there.mean;
  result.p95 = quantile(there.distances, 0.95).value_or(0.0);
  result.from_true = back.mean;
  result.hausdorff = std::max(there.max, back.max);
  result.samples = there.distances.size() + back.distances.size();
  return result;
}

}  // namespace cairn::evaluation
