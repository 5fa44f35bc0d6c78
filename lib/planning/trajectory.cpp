#include "planning/trajectory.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "base/angle.hpp"
#include "base/error.hpp"

namespace cairn::planning {
namespace {

using survey::PolynomialSegment;

constexpr int kDegree = 9;
constexpr double kNoMove = 1e-9;        // m and rad: two keys at one place
constexpr double kPeakGap = 1e-6;       // relative width of the bound on a peak
constexpr double kInside = 1.0 - 1e-6;  // of a limit: room for rounding when the trajectory is sampled
constexpr double kLeastDuration_s = 0.05;

double binomial(int n, int k) {
  double value = 1.0;
  for (int i = 1; i <= k; ++i) value = value * (n - k + i) / i;
  return value;
}

using Bernstein = std::array<double, 2 * kDegree + 1>;  // degree + 1 of them used

// Power basis on [0, 1] -> Bernstein coefficients of the same degree.
Bernstein to_bernstein(const Bernstein& power, int degree) {
  Bernstein out{};
  for (int i = 0; i <= degree; ++i) {
    double sum = 0.0;
    for (int k = 0; k <= i; ++k) sum += binomial(i, k) / binomial(degree, k) * power[static_cast<std::size_t>(k)];
    out[static_cast<std::size_t>(i)] = sum;
  }
  return out;
}

// Largest value on [0, 1] from above, within kPeakGap of it; pieces that cannot raise it are left.
double largest(const Bernstein& coefficients, int degree) {
  struct Piece {
    Bernstein b;
    int depth;
  };
  const auto top = [degree](const Bernstein& b) { return *std::max_element(b.begin(), b.begin() + degree + 1); };
  const auto last = static_cast<std::size_t>(degree);
  double reached = std::max(coefficients[0], coefficients[last]);
  double bound = reached;
  std::vector<Piece> open{{coefficients, 0}};
  while (!open.empty()) {
    const Piece piece = open.back();
    open.pop_back();
    const double high = top(piece.b);
    if (high <= reached * (1.0 + kPeakGap) + 1e-18 || piece.depth > 40) {
      bound = std::max(bound, high);
      continue;
    }
    Piece left{piece.b, piece.depth + 1}, right{piece.b, piece.depth + 1};
    for (int level = 1; level <= degree; ++level) {
      for (int i = degree; i >= level; --i)
        left.b[static_cast<std::size_t>(i)] =
            0.5 * (left.b[static_cast<std::size_t>(i) - 1] + left.b[static_cast<std::size_t>(i)]);
      right.b[static_cast<std::size_t>(degree - level)] = left.b[last];
    }
    right.b[last] = piece.b[last];
    reached = std::max(reached, left.b[last]);
    open.push_back(left);
    open.push_back(right);
  }
  return bound;
}

// Largest norm of a derivative over coordinates [first, end) of a segment.
double largest_norm(const PolynomialSegment& segment, int derivative, std::size_t first, std::size_t end) {
  const int degree = kDegree - derivative;
  Bernstein squared{};
  for (std::size_t d = first; d < end; ++d) {
    std::array<double, kDegree + 1> c{};
    for (int k = 0; k <= degree; ++k) {
      double factor = std::pow(segment.duration_s, k);
      for (int i = 0; i < derivative; ++i) factor *= k + derivative - i;
      c[static_cast<std::size_t>(k)] = factor * segment.coefficients[d][static_cast<std::size_t>(k + derivative)];
    }
    for (std::size_t i = 0; i <= static_cast<std::size_t>(degree); ++i)
      for (std::size_t j = 0; j <= static_cast<std::size_t>(degree); ++j) squared[i + j] += c[i] * c[j];
  }
  return std::sqrt(std::max(0.0, largest(to_bernstein(squared, 2 * degree), 2 * degree)));
}

Peaks segment_peaks(const PolynomialSegment& segment) {
  return {largest_norm(segment, 1, 0, 3), largest_norm(segment, 2, 0, 3),
          base::rad_to_deg(largest_norm(segment, 1, 3, 4))};
}

// By how much a duration must grow that these peaks keep the limits.
double stretch(const Peaks& p, const TrajectoryOptions& options) {
  return std::max({p.speed_m_s / options.max_speed_m_s, std::sqrt(p.acceleration_m_s2 / options.max_acceleration_m_s2),
                   p.yaw_rate_deg_s / options.max_yaw_rate_deg_s}) /
         kInside;
}

// The same trajectory flown `factor` times as slowly; exact where it starts and ends at rest.
void slow_down(std::vector<PolynomialSegment>& trajectory, double factor) {
  for (PolynomialSegment& segment : trajectory) {
    segment.duration_s *= factor;
    for (auto& row : segment.coefficients) {
      double scale = 1.0;
      for (double& c : row) {
        c *= scale;
        scale /= factor;
      }
    }
  }
}

struct Stretch {
  std::vector<Pose4> keys;
  std::vector<std::size_t> key_of;  // index among `keys` of each key given
};

// Coefficients (of t^5 ... t^8) of the distance covered in unit time while the speed grows from 0 to 1 along the smooth
// step 35 u^4 - 84 u^5 + 70 u^6 - 20 u^7, whose derivatives 1 to 3 vanish at both ends.
constexpr std::array<double, 4> kRamp{35.0 / 5.0, -84.0 / 6.0, 70.0 / 7.0, -20.0 / 8.0};
constexpr double kSteepest = 2.1875;  // largest slope of that step

// Straight from rest to rest: speed up, cruise, slow down. Each part is the only polynomial of degree 9 with these
// derivatives 1 to 4 at its ends.
std::vector<PolynomialSegment> straight_leg(const Pose4& a, const Pose4& b, const TrajectoryOptions& options) {
  const Pose4 d = b - a;
  const double length = d.head<3>().norm(), turn = base::rad_to_deg(std::abs(d.w()));
  // Along the fraction 0..1 of the leg.
  double speed = kInside * std::min(options.max_speed_m_s / std::max(length, kNoMove),
                                    options.max_yaw_rate_deg_s / std::max(turn, kNoMove));
  // The turn gains its rate in a second.
  const double acceleration = kInside * std::min(options.max_acceleration_m_s2 / std::max(length, kNoMove),
                                                 kSteepest * options.max_yaw_rate_deg_s / std::max(turn, kNoMove));
  // Where there is no room to cruise, both ramps just meet.
  speed = std::min(speed, std::sqrt(acceleration / kSteepest));
  const double ramp = kSteepest * speed / acceleration;
  const double cruise = std::max(0.0, (1.0 - speed * ramp) / speed);
  const auto part = [&](double T, double from, double at_start, double change) {
    PolynomialSegment segment;
    segment.duration_s = T;
    for (std::size_t c = 0; c < 4; ++c) {
      const auto i = static_cast<Eigen::Index>(c);
      segment.coefficients[c][0] = a(i) + from * d(i);
      segment.coefficients[c][1] = at_start * d(i);
      for (std::size_t k = 0; k < kRamp.size(); ++k)
        segment.coefficients[c][5 + k] = change * kRamp[k] * d(i) / std::pow(T, 4.0 + static_cast<double>(k));
    }
    return segment;
  };
  std::vector<PolynomialSegment> leg{part(ramp, 0.0, 0.0, speed)};
  // Shorter is rounding.
  if (cruise > 1e-9) leg.push_back(part(cruise, 0.5 * speed * ramp, speed, 0.0));
  leg.push_back(part(ramp, 1.0 - 0.5 * speed * ramp, speed, -speed));
  return leg;
}

// Extra keys on the straight lines between keys far apart: beside a long segment a short one costs so much snap that
// the long one would swing far out.
void balance(Stretch& part) {
  double shortest = std::numeric_limits<double>::infinity(), total = 0.0;
  for (std::size_t i = 1; i < part.keys.size(); ++i) {
    const double d = (part.keys[i] - part.keys[i - 1]).norm();
    shortest = std::min(shortest, d);
    total += d;
  }
  constexpr double kMostPieces = 500.0;
  const double longest = std::max(2.0 * shortest, total / kMostPieces);
  std::vector<Pose4> keys{part.keys.front()};
  std::vector<std::size_t> place{0};
  for (std::size_t i = 1; i < part.keys.size(); ++i) {
    const Pose4 from = part.keys[i - 1], to = part.keys[i];
    const auto pieces = static_cast<int>(std::ceil((to - from).norm() / longest));
    for (int k = 1; k <= pieces; ++k)
      keys.push_back(k == pieces ? to : Pose4(from + (to - from) * (static_cast<double>(k) / pieces)));
    place.push_back(keys.size() - 1);
  }
  part.keys = std::move(keys);
  for (std::size_t& k : part.key_of) k = place[k];
}

std::vector<double> nominal_durations(const std::vector<Pose4>& keys, const TrajectoryOptions& options) {
  std::vector<double> durations;
  for (std::size_t i = 1; i < keys.size(); ++i)
    durations.push_back(
        nominal_duration((keys[i] - keys[i - 1]).norm(), options.max_speed_m_s, options.max_acceleration_m_s2));
  return durations;
}

// Least total duration found whose common stretching keeps the limits.
std::vector<PolynomialSegment> within_limits(const std::vector<Pose4>& keys, std::vector<double> durations,
                                             const TrajectoryOptions& options) {
  std::vector<PolynomialSegment> best;
  double best_total = std::numeric_limits<double>::infinity();
  double best_factor = 1.0;
  for (std::int64_t round = 0; round <= options.rounds; ++round) {
    auto trajectory = minimum_snap(keys, durations);
    double worst = 0.0, total = 0.0;
    std::vector<double> need(trajectory.size());
    for (std::size_t s = 0; s < trajectory.size(); ++s) {
      need[s] = stretch(segment_peaks(trajectory[s]), options);
      worst = std::max(worst, need[s]);
      total += durations[s];
    }
    if (worst * total < best_total) {
      best_total = worst * total;
      best_factor = worst;
      best = trajectory;
    }
    // A segment that is alone is settled by the common factor.
    if (trajectory.size() == 1) break;
    for (std::size_t s = 0; s < durations.size(); ++s) {
      constexpr double kCaution = 0.5;
      durations[s] = std::max(kLeastDuration_s, durations[s] * std::clamp(std::pow(need[s], kCaution), 0.7, 1.5));
    }
  }
  slow_down(best, best_factor);
  return best;
}

}  // namespace

double nominal_duration(double d, double v, double a) {
  return 2.0 * d / v * (1.0 + 6.5 * (v / a) * std::exp(-2.0 * d / v));
}

Peaks peaks(std::span<const PolynomialSegment> trajectory) {
  Peaks all;
  for (const PolynomialSegment& segment : trajectory) {
    const Peaks p = segment_peaks(segment);
    all.speed_m_s = std::max(all.speed_m_s, p.speed_m_s);
    all.acceleration_m_s2 = std::max(all.acceleration_m_s2, p.acceleration_m_s2);
    all.yaw_rate_deg_s = std::max(all.yaw_rate_deg_s, p.yaw_rate_deg_s);
  }
  return all;
}

Flight plan_flight(std::span<const FlightKey> keys, const TrajectoryOptions& options) {
  TrajectoryOptions checked = options;
  base::validate(base::bind_options(checked), "trajectory");
  if (keys.empty()) throw base::Error(base::ErrorCode::invalid_argument, "a flight without a key").allowed("1 or more");
  for (const FlightKey& key : keys)
    if (!key.pose.allFinite())
      throw base::Error(base::ErrorCode::invalid_argument, "a key of the flight is not finite");

  Flight flight;
  flight.key_times_s.assign(keys.size(), 0.0);
  double now = 0.0;
  for (std::size_t begin = 0; begin + 1 < keys.size();) {
    std::size_t end = begin + 1;
    while (end + 1 < keys.size() && !keys[end].stop) ++end;
    Stretch part;
    for (std::size_t i = begin; i <= end; ++i) {
      if (part.keys.empty() || (keys[i].pose - part.keys.back()).cwiseAbs().maxCoeff() > kNoMove)
        part.keys.push_back(keys[i].pose);
      part.key_of.push_back(part.keys.size() - 1);
    }
    std::vector<double> arrival(1, 0.0);
    if (part.keys.size() > 1) {
      const bool robust = options.mode == "robust";
      const bool straight = robust && part.keys.size() == 2;
      if (robust && !straight) balance(part);
      const auto durations = nominal_durations(part.keys, options);
      auto trajectory = straight ? straight_leg(part.keys[0], part.keys[1], options)
                        : robust ? within_limits(part.keys, durations, options)
                                 : minimum_snap(part.keys, durations);
      for (const PolynomialSegment& segment : trajectory) {
        arrival.push_back(arrival.back() + segment.duration_s);
        flight.trajectory.push_back(segment);
      }
      if (straight)
        for (std::size_t& k : part.key_of) k = k == 0 ? 0 : arrival.size() - 1;
    }
    for (std::size_t i = begin; i <= end; ++i) flight.key_times_s[i] = now + arrival[part.key_of[i - begin]];
    now += arrival.back();
    begin = end;
  }
  flight.peaks = peaks(flight.trajectory);
  return flight;
}

}  // namespace cairn::planning
