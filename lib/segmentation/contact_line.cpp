#include "segmentation/contact_line.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <tuple>

#include "geometry/kd_tree.hpp"
#include "segmentation/patch_graph.hpp"

namespace cairn::segmentation {
namespace {

using geometry::Vec2;
using geometry::Vec3;

constexpr double kTurn = 2.0 * std::numbers::pi;
// All in spacings of the points.
constexpr double kSectorLength = 3.0;  // along the rim
constexpr double kHalfStrip = 3.5;     // of the points of one profile
constexpr double kReach = 12.0;        // of a profile
constexpr double kSeatScale = 5.0;     // e-folding of a point's say, seat: ledges are narrow
constexpr double kFlankScale = 6.0;    // and flank
constexpr double kSmoothing = 5.0;     // standard deviation along the rim
constexpr double kSeen = 4.0;          // points of both surfaces this near to the line: it was seen
constexpr double kMovement = 6.0;      // most that a fit may move the line
constexpr std::array<double, 4> kSeedCells = {4.0, 8.0, 14.0, 24.0};
constexpr double kOpenNoises = 2.5;  // opening of a wedge, over the noise, at which it shows as open
constexpr int kRounds = 6;
constexpr int kPasses = 2;

double median(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

struct Seed {
  Vec3 position;
  std::size_t level;
};

// Cubes that hold points of the rock and others, at growing sizes: about where the two meet.
std::vector<Seed> meeting_places(std::span<const Vec3> points, std::span<const Side> sides, double spacing) {
  std::vector<Seed> seeds;
  struct Keyed {
    std::array<std::int64_t, 3> cube;
    std::uint32_t point;
  };
  std::vector<Keyed> keyed;
  for (std::size_t level = 0; level < kSeedCells.size(); ++level) {
    const double cell = kSeedCells[level] * spacing;
    keyed.clear();
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (sides[i] == Side::unknown && level > 0) continue;
      const Vec3 q = points[i] / cell;
      keyed.push_back({{static_cast<std::int64_t>(std::floor(q.x())), static_cast<std::int64_t>(std::floor(q.y())),
                        static_cast<std::int64_t>(std::floor(q.z()))},
                       static_cast<std::uint32_t>(i)});
    }
    std::sort(keyed.begin(), keyed.end(),
              [](const Keyed& a, const Keyed& b) { return std::tie(a.cube, a.point) < std::tie(b.cube, b.point); });
    for (std::size_t k = 0; k < keyed.size();) {
      std::size_t count[3] = {0, 0, 0};
      Vec3 sum[3] = {Vec3::Zero(), Vec3::Zero(), Vec3::Zero()};
      const std::size_t first = k;
      for (; k < keyed.size() && keyed[k].cube == keyed[first].cube; ++k) {
        const auto side = static_cast<std::size_t>(sides[keyed[k].point]);
        ++count[side];
        sum[side] += points[keyed[k].point];
      }
      if (count[2] > 0) seeds.push_back({sum[2] / static_cast<double>(count[2]), level});
      else if (count[0] > 0 && count[1] > 0)
        seeds.push_back(
            {0.5 * (sum[0] / static_cast<double>(count[0]) + sum[1] / static_cast<double>(count[1])), level});
    }
  }
  return seeds;
}

// What the profiles do not say of one another: the two surfaces are not straight, their noise is not independent.
constexpr double kModelError = 0.7;  // spacings

// A weighted line in the plane of a profile.
struct Line {
  Vec2 middle = Vec2::Zero(), along = Vec2::UnitX();
  double weight = 0.0, spread = 0.0;
  [[nodiscard]] double off(const Vec2& p) const { return along.x() * (p - middle).y() - along.y() * (p - middle).x(); }
};

struct Sample {
  Vec2 p;  // outward, up; from the base of the profile
  Side side;
};

Line fit_line(const std::vector<Sample>& samples, Side side, const Vec2& crease, double scale, const Line* last,
              double noise) {
  Line line;
  Vec2 mean = Vec2::Zero();
  std::vector<double> weights(samples.size(), 0.0);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (samples[i].side != side) continue;
    double w = std::exp(-(samples[i].p - crease).squaredNorm() / (scale * scale));
    if (last != nullptr) {
      const double t = last->off(samples[i].p) / (3.5 * noise);
      w *= t * t < 1.0 ? (1.0 - t * t) * (1.0 - t * t) : 0.0;
    }
    weights[i] = w;
    line.weight += w;
    mean += w * samples[i].p;
  }
  if (line.weight < 2.0) {
    line.weight = 0.0;
    return line;
  }
  mean /= line.weight;
  double xx = 0.0, xy = 0.0, yy = 0.0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (weights[i] <= 0.0) continue;
    const Vec2 d = samples[i].p - mean;
    xx += weights[i] * d.x() * d.x(), xy += weights[i] * d.x() * d.y(), yy += weights[i] * d.y() * d.y();
  }
  const double angle = 0.5 * std::atan2(2.0 * xy, xx - yy);
  line.middle = mean;
  line.along = Vec2(std::cos(angle), std::sin(angle));
  if (line.along.dot(mean - crease) < 0.0) line.along = -line.along;
  line.spread = std::sqrt(std::max(1e-18, 0.5 * (xx + yy + std::hypot(xx - yy, 2.0 * xy)) / line.weight));
  return line;
}

double distance_to_ray(const Vec2& p, const Vec2& from, const Vec2& along) {
  const Vec2 d = p - from;
  const double t = std::max(0.0, d.dot(along));
  return (d - t * along).norm();
}

struct Fit {
  bool good = false;
  Vec2 crease = Vec2::Zero(), flank = Vec2::UnitY(), seat = Vec2::UnitX();
  double sigma = 0.0, residual = 0.0;
  bool observed = false;
};

Fit fit_profile(std::vector<Sample> samples, double spacing) {
  Fit fit;
  double noise = 0.8 * spacing;
  Line flank, seat;
  bool have = false;
  for (int round = 0; round < kRounds; ++round) {
    flank = fit_line(samples, Side::rock, fit.crease, kFlankScale * spacing, have ? &flank : nullptr, noise);
    seat = fit_line(samples, Side::other, fit.crease, kSeatScale * spacing, have ? &seat : nullptr, noise);
    if (flank.weight <= 0.0 || seat.weight <= 0.0) return fit;
    const double cross = flank.along.x() * seat.along.y() - flank.along.y() * seat.along.x();
    if (std::abs(cross) < 0.17) return fit;  // 10 deg: no telling where they meet
    const Vec2 between = seat.middle - flank.middle;
    const double t = (between.x() * seat.along.y() - between.y() * seat.along.x()) / cross;
    const Vec2 meeting = flank.middle + t * flank.along;
    if (meeting.norm() > kMovement * spacing) return fit;
    fit.crease = meeting;
    if (flank.along.dot(flank.middle - meeting) < 0.0) flank.along = -flank.along;
    if (seat.along.dot(seat.middle - meeting) < 0.0) seat.along = -seat.along;
    have = true;
    std::vector<double> residuals;
    for (auto& s : samples) {
      const double to_flank = distance_to_ray(s.p, meeting, flank.along);
      const double to_seat = distance_to_ray(s.p, meeting, seat.along);
      const double d = (s.p - meeting).norm();
      if (d < kSeatScale * spacing) {
        s.side = to_flank < to_seat ? Side::rock : Side::other;
        residuals.push_back(std::min(to_flank, to_seat));
      }
    }
    if (residuals.size() >= 6) noise = std::clamp(1.4826 * median(residuals), 0.15 * spacing, 1.5 * spacing);
  }
  fit.flank = flank.along;
  fit.seat = seat.along;
  const double sine = std::abs(fit.flank.x() * fit.seat.y() - fit.flank.y() * fit.seat.x());
  const auto error = [&](const Line& line) {
    const double lever = (line.middle - fit.crease).norm() / std::max(line.spread, 1e-9);
    return noise * std::sqrt((1.0 + lever * lever) / line.weight);
  };
  fit.sigma = std::hypot(error(flank), error(seat)) / std::max(sine, 0.2);
  fit.residual = noise;
  // A narrow wedge is seen as closed where it is no wider than the noise, and a crease that does not bear is open by
  // some millimetres: what shows as the rim lies out there, not where the two lines would meet.
  const double cosine = fit.flank.dot(fit.seat);
  if (cosine > 0.0) fit.crease += kOpenNoises * noise * cosine / std::max(sine, 0.25) * fit.seat;
  bool near_flank = false, near_seat = false;
  for (const auto& s : samples)
    if ((s.p - fit.crease).norm() < kSeen * spacing) {
      near_flank = near_flank || s.side == Side::rock;
      near_seat = near_seat || s.side == Side::other;
    }
  fit.observed = near_flank && near_seat;
  fit.good = true;
  return fit;
}

// Radius and height over the direction about a middle.
struct Rim {
  Vec2 middle = Vec2::Zero();
  std::vector<double> radius, height, sigma;
  std::vector<std::uint8_t> known;

  [[nodiscard]] std::size_t size() const { return radius.size(); }
  [[nodiscard]] double angle(std::size_t k) const {
    return kTurn * (static_cast<double>(k) + 0.5) / static_cast<double>(size());
  }
  [[nodiscard]] Vec3 at(std::size_t k) const {
    return {middle.x() + radius[k] * std::cos(angle(k)), middle.y() + radius[k] * std::sin(angle(k)), height[k]};
  }
  // In plan, to the right of the way round.
  [[nodiscard]] Vec2 outward(std::size_t k) const {
    const std::size_t n = size();
    const Vec2 t = (at((k + 2) % n) - at((k + n - 2) % n)).head<2>();
    const Vec2 out(t.y(), -t.x());
    const double length = out.norm();
    return length > 0.0 ? Vec2(out / length) : Vec2(std::cos(angle(k)), std::sin(angle(k)));
  }
};

std::size_t sector_of(const Vec2& d, std::size_t sectors) {
  double a = std::atan2(d.y(), d.x());
  if (a < 0.0) a += kTurn;
  return std::min(sectors - 1, static_cast<std::size_t>(a / kTurn * static_cast<double>(sectors)));
}

// Straight between the known neighbours, round the circle.
void fill_unknown(Rim& rim) {
  const std::size_t n = rim.size();
  std::vector<std::size_t> known;
  for (std::size_t k = 0; k < n; ++k)
    if (rim.known[k] != 0) known.push_back(k);
  if (known.empty()) return;
  for (std::size_t m = 0; m < known.size(); ++m) {
    const std::size_t a = known[m], b = known[(m + 1) % known.size()];
    const std::size_t gap = (b + n - a) % n == 0 ? n : (b + n - a) % n;
    for (std::size_t g = 1; g < gap; ++g) {
      const double t = static_cast<double>(g) / static_cast<double>(gap);
      const std::size_t k = (a + g) % n;
      rim.radius[k] = (1.0 - t) * rim.radius[a] + t * rim.radius[b];
      rim.height[k] = (1.0 - t) * rim.height[a] + t * rim.height[b];
    }
  }
}

// Median of five along the rim, for what the seeds give.
void reject_strays(Rim& rim) {
  const std::size_t n = rim.size();
  auto radius = rim.radius, height = rim.height;
  for (std::size_t k = 0; k < n; ++k) {
    std::vector<double> r, z;
    for (std::size_t o = 0; o < 5; ++o) {
      r.push_back(rim.radius[(k + n + o - 2) % n]);
      z.push_back(rim.height[(k + n + o - 2) % n]);
    }
    radius[k] = median(r), height[k] = median(z);
  }
  rim.radius = std::move(radius), rim.height = std::move(height);
}

struct Measured {
  double angle, radius, height, variance;
};

// Local straight lines over the direction, weighted by nearness and by precision; a second round without strays.
void smooth(Rim& rim, std::vector<Measured> measured, double spacing) {
  const std::size_t n = rim.size();
  double perimeter = 0.0;
  for (std::size_t k = 0; k < n; ++k) perimeter += (rim.at(k) - rim.at((k + 1) % n)).norm();
  const double width = kTurn * kSmoothing * spacing / std::max(perimeter, 1e-9);
  for (int round = 0; round < 2; ++round) {
    std::vector<double> radius(n), height(n), sigma(n);
    for (std::size_t k = 0; k < n; ++k) {
      double scale = width;
      for (int widen = 0;; ++widen, scale *= 2.0) {
        double w0 = 0, w1 = 0, w2 = 0, r0 = 0, r1 = 0, z0 = 0, z1 = 0, squares = 0, variance = 0;
        for (const auto& m : measured) {
          const double d = std::remainder(m.angle - rim.angle(k), kTurn);
          if (std::abs(d) > 3.0 * scale) continue;
          const double w = std::exp(-0.5 * d * d / (scale * scale)) / (m.variance + 0.04 * spacing * spacing);
          w0 += w, w1 += w * d, w2 += w * d * d, r0 += w * m.radius, r1 += w * d * m.radius;
          z0 += w * m.height, z1 += w * d * m.height;
          squares += w * w, variance += w * w * (m.variance + 0.04 * spacing * spacing);
        }
        const double determinant = w0 * w2 - w1 * w1;
        if (w0 > 0.0 && determinant > 1e-9 * w0 * w0 * scale * scale) {
          radius[k] = (w2 * r0 - w1 * r1) / determinant;
          height[k] = (w2 * z0 - w1 * z1) / determinant;
          sigma[k] = std::sqrt(variance) / w0 * (1.0 + widen);
          break;
        }
        if (scale > kTurn) {
          radius[k] = rim.radius[k], height[k] = rim.height[k], sigma[k] = 10.0 * spacing;
          break;
        }
      }
    }
    rim.radius = radius, rim.height = height, rim.sigma = sigma;
    if (round > 0 || measured.size() < 8) break;
    std::vector<double> off;
    const auto distance = [&](const Measured& m) {
      const std::size_t k = sector_of({std::cos(m.angle), std::sin(m.angle)}, n);
      return std::hypot(m.radius - rim.radius[k], m.height - rim.height[k]);
    };
    for (const auto& m : measured) off.push_back(distance(m));
    const double limit = std::max(4.0 * 1.4826 * median(off), 0.5 * spacing);
    std::erase_if(measured, [&](const Measured& m) { return distance(m) > limit; });
  }
}

}  // namespace

double ContactLine::observed_share() const {
  if (profiles.empty()) return 0.0;
  const auto seen = std::count_if(profiles.begin(), profiles.end(), [](const auto& p) { return p.observed; });
  return static_cast<double>(seen) / static_cast<double>(profiles.size());
}

survey::Contact ContactLine::contact() const {
  survey::Contact contact;
  std::int64_t order = 0;
  for (const auto& p : profiles) {
    if (!contact.empty() && contact.back().pad != static_cast<std::int64_t>(p.pad)) order = 0;
    contact.push_back({static_cast<std::int64_t>(p.pad), order++, p.position, p.observed, true, p.sigma});
  }
  return contact;
}

ContactLine fit_contact(std::span<const Vec3> points, std::span<const Side> sides, double spacing) {
  ContactLine line;
  const auto seeds = meeting_places(points, sides, spacing);
  if (seeds.size() < 3) return line;
  // The finest level that has a fair number of seeds gives the middle: of the seeds' box, since they are uneven.
  Rim rim;
  std::vector<const Seed*> used;
  for (std::size_t level = 0; level < kSeedCells.size() && used.size() < 8; ++level)
    for (const auto& s : seeds)
      if (s.level == level) used.push_back(&s);
  {
    std::vector<double> x, y;
    for (const auto* s : used) x.push_back(s->position.x()), y.push_back(s->position.y());
    std::sort(x.begin(), x.end()), std::sort(y.begin(), y.end());
    const std::size_t low = x.size() / 50, high = x.size() - 1 - low;
    rim.middle = 0.5 * Vec2(x[low] + x[high], y[low] + y[high]);
    const double around = std::numbers::pi * 0.5 * (x[high] - x[low] + y[high] - y[low]);
    const auto n = static_cast<std::size_t>(std::clamp(around / (kSectorLength * spacing), 24.0, 240.0));
    rim.radius.assign(n, 0.0), rim.height.assign(n, 0.0), rim.sigma.assign(n, 0.0), rim.known.assign(n, 0);
  }
  const std::size_t n = rim.size();
  std::vector<std::array<std::vector<Vec2>, kSeedCells.size()>> by_sector(n);
  for (const auto& s : seeds) {
    const Vec2 d = s.position.head<2>() - rim.middle;
    by_sector[sector_of(d, n)][s.level].push_back({d.norm(), s.position.z()});
  }
  for (std::size_t k = 0; k < n; ++k)
    for (const auto& found : by_sector[k]) {
      if (found.empty()) continue;
      std::vector<double> r, z;
      for (const auto& q : found) r.push_back(q.x()), z.push_back(q.y());
      rim.radius[k] = median(r), rim.height[k] = median(z), rim.known[k] = 1;
      break;
    }
  fill_unknown(rim);
  reject_strays(rim);

  const geometry::KdTree tree(points);
  std::vector<Fit> fits(n);
  for (int pass = 0; pass < kPasses; ++pass) {
    std::vector<Measured> measured;
    for (std::size_t k = 0; k < n; ++k) {
      const Vec3 base = rim.at(k);
      const Vec2 out = rim.outward(k), side(-out.y(), out.x());
      std::vector<Sample> samples;
      for (const auto& near : tree.within(base, kReach * spacing)) {
        const Vec3 d = points[near.index] - base;
        if (std::abs(d.head<2>().dot(side)) <= kHalfStrip * spacing)
          samples.push_back({Vec2(d.head<2>().dot(out), d.z()), sides[near.index]});
      }
      fits[k] = fit_profile(std::move(samples), spacing);
      if (!fits[k].good) continue;
      const Vec2 at = base.head<2>() + fits[k].crease.x() * out - rim.middle;
      measured.push_back(
          {std::atan2(at.y(), at.x()), at.norm(), base.z() + fits[k].crease.y(), fits[k].sigma * fits[k].sigma});
    }
    if (measured.size() < 6) break;
    smooth(rim, std::move(measured), spacing);
  }
  std::vector<double> residuals;
  for (std::size_t k = 0; k < n; ++k) {
    ContactProfile p;
    p.position = rim.at(k);
    p.outward = rim.outward(k);
    p.sigma = std::hypot(rim.sigma[k], kModelError * spacing);
    std::size_t nearest = n;  // a profile that could not be fitted takes its neighbour's surfaces
    for (std::size_t o = 0; o <= n / 2 && nearest == n; ++o)
      for (const std::size_t j : {(k + o) % n, (k + n - o) % n})
        if (fits[j].good) nearest = j;
    if (nearest < n) p.flank = fits[nearest].flank, p.seat = fits[nearest].seat;
    p.observed = fits[k].good && fits[k].observed;
    if (!fits[k].good) p.sigma = std::max(p.sigma, 3.0 * spacing);
    if (fits[k].good) residuals.push_back(fits[k].residual);
    line.profiles.push_back(p);
  }
  if (!residuals.empty()) line.residual = median(residuals);
  return line;
}

survey::Contact contact_from_labels(std::span<const Vec3> points, std::span<const Label> labels) {
  std::vector<Vec3> used;
  std::vector<Side> sides;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!points[i].allFinite()) continue;
    used.push_back(points[i]);
    sides.push_back(labels[i] == Label::rock            ? Side::rock
                    : labels[i] == Label::basal_contact ? Side::unknown
                                                        : Side::other);
  }
  const double spacing = point_spacing(used);
  if (spacing <= 0.0) return {};
  return fit_contact(used, sides, spacing).contact();
}

}  // namespace cairn::segmentation
