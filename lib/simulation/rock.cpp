#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numbers>

#include "base/angle.hpp"
#include "geometry/mass_properties.hpp"
#include "simulation/noise.hpp"
#include "simulation/resting_body.hpp"
#include "simulation/rock_form.hpp"

namespace cairn::simulation {
namespace {

using geometry::Mat3;
using geometry::Vec2;
using geometry::Vec3;

constexpr double kTurn = 2.0 * std::numbers::pi;
constexpr int kScanSteps = 128;

Vec3 unit(double polar, double azimuth) {
  return {std::sin(polar) * std::cos(azimuth), std::sin(polar) * std::sin(azimuth), std::cos(polar)};
}

// Height of the seat in the form's own units: a slope and gentle undulation.
struct Seat {
  double depth = 0.0;  // below the form's inner point
  Vec2 slope = Vec2::Zero();
  double relief = 0.0;
  std::uint64_t seed = 0;

  [[nodiscard]] double at(double x, double y) const {
    return -depth + slope.x() * x + slope.y() * y + relief * fractal_noise({1.7 * x, 1.7 * y, 0.5}, seed, 2);
  }
};

// Depth of the seat at which the rim's mean radius is `share` of the widest section's.
double seat_depth(const RockForm& form, double share) {
  constexpr int kAzimuths = 24;
  std::vector<std::array<Vec2, kScanSteps + 1>> profiles(kAzimuths);  // radius, height; top to bottom
  double widest = 0.0, deepest = 1e300;
  for (int a = 0; a < kAzimuths; ++a) {
    double most = 0.0;
    for (int i = 0; i <= kScanSteps; ++i) {
      const double polar = std::numbers::pi * i / kScanSteps;
      const double r = form.radius(unit(polar, kTurn * a / kAzimuths));
      profiles[static_cast<std::size_t>(a)][static_cast<std::size_t>(i)] = {r * std::sin(polar), r * std::cos(polar)};
      most = std::max(most, r * std::sin(polar));
    }
    widest += most / kAzimuths;
    deepest = std::min(deepest, form.radius(-Vec3::UnitZ()));
  }
  const auto rim_radius = [&](double depth) {
    double sum = 0.0;
    for (const auto& profile : profiles)
      for (std::size_t i = 1; i < profile.size(); ++i)
        if (profile[i].y() < -depth) {
          sum += profile[i].x();
          break;
        }
    return sum / kAzimuths;
  };
  double lo = 0.1 * deepest, hi = 0.98 * deepest;
  for (int i = 0; i < 40; ++i) {
    const double middle = 0.5 * (lo + hi);
    (rim_radius(middle) > share * widest ? lo : hi) = middle;
  }
  return 0.5 * (lo + hi);
}

// Polar angle of the first descent through the seat (raised by `gap`), seen from the top.
double rim_angle(const RockForm& form, const Seat& seat, double gap, double azimuth) {
  const auto above = [&](double polar) {
    const Vec3 u = unit(polar, azimuth);
    const Vec3 p = form.radius(u) * u;
    return p.z() - seat.at(p.x(), p.y()) - gap;
  };
  double hi = std::numbers::pi;
  for (int i = kScanSteps / 3; i <= kScanSteps; ++i)
    if (const double polar = std::numbers::pi * i / kScanSteps; above(polar) < 0.0) {
      hi = polar;
      break;
    }
  double lo = hi - std::numbers::pi / kScanSteps;
  for (int i = 0; i < 50; ++i) {
    const double middle = 0.5 * (lo + hi);
    (above(middle) > 0.0 ? lo : hi) = middle;
  }
  return 0.5 * (lo + hi);
}

// Fractions 0..1 of the way from the top to the rim, such that rings are evenly spaced along the surface.
std::vector<double> ring_fractions(const RockForm& form, const std::vector<double>& rims, const Vec3& scale,
                                   double edge) {
  constexpr int kSteps = 200;
  std::vector<double> along(kSteps + 1, 0.0);
  constexpr int kAzimuths = 8;
  for (int a = 0; a < kAzimuths; ++a) {
    const std::size_t sector = rims.size() * static_cast<std::size_t>(a) / kAzimuths;
    const double azimuth = kTurn * static_cast<double>(sector) / static_cast<double>(rims.size());
    Vec3 last = Vec3::Zero();
    double length = 0.0;
    for (int i = 0; i <= kSteps; ++i) {
      const Vec3 u = unit(rims[sector] * i / kSteps, azimuth);
      const Vec3 p = scale.cwiseProduct(form.radius(u) * u);
      if (i > 0) length += (p - last).norm();
      along[static_cast<std::size_t>(i)] += length / kAzimuths;
      last = p;
    }
  }
  const auto rings = static_cast<std::size_t>(std::clamp(std::ceil(along.back() / edge), 8.0, 4000.0));
  std::vector<double> fractions;
  std::size_t i = 0;
  for (std::size_t k = 1; k < rings; ++k) {
    const double wanted = along.back() * static_cast<double>(k) / static_cast<double>(rings);
    while (along[i + 1] < wanted) ++i;
    fractions.push_back((static_cast<double>(i) + (wanted - along[i]) / (along[i + 1] - along[i])) / kSteps);
  }
  fractions.push_back(1.0);
  return fractions;
}

double plan_area(const Ring3& ring) {
  double twice = 0.0;
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const Vec3 &a = ring[i], &b = ring[(i + 1) % ring.size()];
    twice += a.x() * b.y() - a.y() * b.x();
  }
  return 0.5 * twice;
}

Vec2 plan_centroid(const Ring3& ring) {
  Vec2 sum = Vec2::Zero();
  double twice = 0.0;
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const Vec2 a = ring[i].head<2>(), b = ring[(i + 1) % ring.size()].head<2>();
    const double cross = a.x() * b.y() - a.y() * b.x();
    twice += cross;
    sum += cross * (a + b);
  }
  return sum / (3.0 * twice);
}

struct Pad {
  Vec2 centre;
  double radius;
};

// Where the body touches its seat, in the form's units.
struct Bearing {
  std::vector<double> ring;  // one area: radius by sector; empty when it is several pads
  std::vector<Pad> pads;
};

double star_area(const std::vector<double>& radii) {
  double sum = 0.0;
  for (std::size_t i = 0; i < radii.size(); ++i) sum += radii[i] * radii[(i + 1) % radii.size()];
  return 0.5 * sum * std::sin(kTurn / static_cast<double>(radii.size()));
}

Bearing make_bearing(const ShapeSpec& spec, const std::vector<double>& rim, base::Random& random) {
  Bearing bearing;
  const std::size_t n = rim.size();
  if (spec.contact_pads == 1) {
    if (spec.contact_share >= 1.0) {
      bearing.ring = rim;
      return bearing;
    }
    const std::uint64_t seed = random.bits();
    std::vector<double> wander(n);
    for (std::size_t i = 0; i < n; ++i) {
      const double a = kTurn * static_cast<double>(i) / static_cast<double>(n);
      wander[i] = 1.0 + 0.3 * spec.irregularity * value_noise({1.3 * std::cos(a), 1.3 * std::sin(a), 0.5}, seed);
    }
    bearing.ring.resize(n);
    const double wanted = spec.contact_share * star_area(rim);
    double lo = 0.0, hi = 2.0;
    for (int k = 0; k < 60; ++k) {
      const double scale = 0.5 * (lo + hi);
      for (std::size_t i = 0; i < n; ++i) bearing.ring[i] = rim[i] * std::min(1.0, scale * wander[i]);
      (star_area(bearing.ring) < wanted ? lo : hi) = scale;
    }
    return bearing;
  }
  constexpr double kInside = 0.88;  // pads keep this share of the rim's smallest radius
  const double pads = spec.contact_pads, spread = 0.9 * std::sin(std::numbers::pi / pads);
  const double least = *std::min_element(rim.begin(), rim.end());
  const double radius = std::min(std::sqrt(spec.contact_share * star_area(rim) / (std::numbers::pi * pads)),
                                 kInside * least * spread / (1.0 + spread));
  const double first = random.uniform(0.0, kTurn);
  for (int k = 0; k < spec.contact_pads; ++k) {
    const double a = first + kTurn * k / pads;
    bearing.pads.push_back({(kInside * least - radius) * Vec2(std::cos(a), std::sin(a)), radius});
  }
  return bearing;
}

double smooth_step(double t) {
  t = std::clamp(t, 0.0, 1.0);
  return t * t * (3.0 - 2.0 * t);
}

// Share of the crease's opening at a point of the underside.
double opening(const Bearing& bearing, const Vec2& p, double radius, double rim, double bearing_radius) {
  if (bearing.pads.empty()) {
    if (radius <= bearing_radius || rim <= bearing_radius) return 0.0;
    return smooth_step((radius - bearing_radius) / (rim - bearing_radius));
  }
  double outside = 1e300;
  for (const Pad& pad : bearing.pads) outside = std::min(outside, (p - pad.centre).norm() - pad.radius);
  return std::max(smooth_step(outside / (0.2 * rim)), smooth_step((radius / rim - 0.9) / 0.1));
}

// The body in the form's units, with the pieces that the final stretch and lean carry along.
struct FormBody {
  Seat seat;
  std::vector<double> rim_radius;
  std::vector<Ring3> rings;  // top to bottom, last = innermost of the underside
  Vec3 top, bottom;
  Ring3 rim;
  std::vector<Ring3> bearing;
};

FormBody build(const RockForm& form, const Seat& seat, const ShapeSpec& spec, const Vec3& scale, double edge,
               base::Random& random) {
  FormBody b;
  b.seat = seat;
  const double gap = spec.contact_pads > 1 || spec.contact_share < 1.0 ? spec.contact_gap_m / scale.z() : 0.0;
  const double around = std::numbers::pi * 0.5 * (spec.size_m.x() + spec.size_m.y());
  const auto n = static_cast<std::size_t>(4.0 * std::clamp(std::ceil(around / edge / 4.0), 8.0, 1000.0));
  const auto azimuth = [n](std::size_t i) { return kTurn * static_cast<double>(i) / static_cast<double>(n); };
  std::vector<double> rims(n);
  for (std::size_t i = 0; i < n; ++i) rims[i] = rim_angle(form, seat, gap, azimuth(i));
  for (const double fraction : ring_fractions(form, rims, scale, edge)) {
    Ring3 ring(n);
    for (std::size_t i = 0; i < n; ++i) {
      const Vec3 u = unit(fraction * rims[i], azimuth(i));
      ring[i] = form.radius(u) * u;
    }
    b.rings.push_back(std::move(ring));
  }
  b.top = form.radius(Vec3::UnitZ()) * Vec3::UnitZ();
  b.rim = b.rings.back();
  for (const Vec3& p : b.rim) b.rim_radius.push_back(p.head<2>().norm());

  const Bearing bearing = make_bearing(spec, b.rim_radius, random);
  const double mean_rim = std::sqrt(star_area(b.rim_radius) / std::numbers::pi);
  const auto inner = static_cast<std::size_t>(std::clamp(std::ceil(mean_rim * scale.x() / edge), 4.0, 2000.0));
  // Fractions of the rim's radius; the edge of a single bearing area is a ring of the mesh, so that it is sharp.
  const bool split = bearing.pads.empty() && spec.contact_share < 1.0;
  const auto outer = split ? std::max<std::size_t>(2, inner / 3) : 0;
  const auto underside = [&](std::size_t i, double radius) {
    const Vec2 p = radius * Vec2(std::cos(azimuth(i)), std::sin(azimuth(i)));
    const double inside = bearing.pads.empty() ? bearing.ring[i] : 0.0;
    return Vec3(p.x(), p.y(), seat.at(p.x(), p.y()) + gap * opening(bearing, p, radius, b.rim_radius[i], inside));
  };
  const auto add_ring = [&](const std::function<double(std::size_t)>& radius) {
    Ring3 ring(n);
    for (std::size_t i = 0; i < n; ++i) ring[i] = underside(i, radius(i));
    b.rings.push_back(std::move(ring));
  };
  for (std::size_t k = 1; k <= outer; ++k)
    add_ring([&](std::size_t i) {
      const double t = static_cast<double>(k) / static_cast<double>(outer);
      return b.rim_radius[i] + t * (bearing.ring[i] - b.rim_radius[i]);
    });
  if (bearing.pads.empty()) b.bearing.push_back(split ? b.rings.back() : b.rim);
  for (std::size_t k = 1; k < inner; ++k)
    add_ring([&](std::size_t i) {
      const double from = split ? bearing.ring[i] : b.rim_radius[i];
      return from * (1.0 - static_cast<double>(k) / static_cast<double>(inner));
    });
  b.bottom = Vec3(0.0, 0.0, seat.at(0.0, 0.0) + gap * opening(bearing, Vec2::Zero(), 0.0, mean_rim, mean_rim));
  for (const Pad& pad : bearing.pads) {
    constexpr int kPadPoints = 64;
    Ring3 ring;
    for (int k = 0; k < kPadPoints; ++k) {
      const double a = kTurn * k / kPadPoints;
      const Vec2 p = pad.centre + pad.radius * Vec2(std::cos(a), std::sin(a));
      ring.emplace_back(p.x(), p.y(), seat.at(p.x(), p.y()));
    }
    b.bearing.push_back(std::move(ring));
  }
  return b;
}

// Where the centre of mass shall stand above the contact: its middle, and a little off it.
Vec2 wanted_plumb_point(const std::vector<Ring3>& bearing, double share_of_way, double direction) {
  if (bearing.size() == 1) {
    const Vec2 middle = plan_centroid(bearing.front());
    const auto i = static_cast<std::size_t>(direction * static_cast<double>(bearing.front().size()));
    return middle + share_of_way * (bearing.front()[i].head<2>() - middle);
  }
  Vec2 middle = Vec2::Zero();
  for (const Ring3& pad : bearing) middle += plan_centroid(pad) / static_cast<double>(bearing.size());
  const double radius = std::sqrt(plan_area(bearing.front()) / std::numbers::pi);
  return middle + share_of_way * radius * Vec2(std::cos(kTurn * direction), std::sin(kTurn * direction));
}

Mat3 lean(const Vec2& shear) {
  Mat3 m = Mat3::Identity();
  m(0, 2) = shear.x();
  m(1, 2) = shear.y();
  return m;
}

}  // namespace

RestingBody make_rock(const ShapeSpec& spec, double edge, base::Random& random) {
  RestingBody rock;
  rock.family = spec.family.empty() ? rock_families()[random.below(rock_families().size())] : spec.family;
  const auto form = std::make_shared<RockForm>(rock.family, spec.irregularity, random);
  const double drawn_share = random.uniform(0.35, 0.7);
  Seat seat;
  seat.depth = seat_depth(*form, spec.foot_share > 0.0 ? spec.foot_share : drawn_share);
  const double slope = std::tan(base::deg_to_rad(random.uniform(0.0, 2.0 + 5.0 * spec.irregularity)));
  const double slope_direction = random.uniform(0.0, kTurn);
  seat.slope = slope * Vec2(std::cos(slope_direction), std::sin(slope_direction));
  seat.relief = 0.015 + 0.06 * spec.irregularity;
  seat.seed = random.bits();
  const double off_middle = random.uniform(0.0, 0.4), off_direction = random.uniform();

  const Vec3 rough_scale = spec.size_m.cwiseQuotient(Vec3(2.0, 2.0, form->radius(Vec3::UnitZ()) + seat.depth));
  FormBody b = build(*form, seat, spec, rough_scale, edge, random);
  rock.body = ring_mesh(b.top, b.rings, b.bottom);

  // A lean carries the centre of mass over the contact. The stretch to size comes after it and depends on it, and
  // a tilt is answered in stretched metres: a few rounds settle all three.
  const auto mass = geometry::mass_properties(rock.body);
  const Vec2 plumb = wanted_plumb_point(b.bearing, off_middle, off_direction);
  const double seat_height = seat.at(plumb.x(), plumb.y()), arm = mass.centre_of_mass.z() - seat_height;
  const double tilt = std::tan(base::deg_to_rad(spec.tilt_deg));
  Vec3 scale = rough_scale;
  Mat3 shape = Mat3::Identity();
  for (int round = 0; round < 40; ++round) {
    Vec2 target = plumb;
    target.x() -= scale.z() / scale.x() * arm * tilt;
    const Mat3 leaning = lean((target - mass.centre_of_mass.head<2>()) / arm);
    geometry::TriangleMesh leant;
    for (const Vec3& v : rock.body.vertices) leant.vertices.push_back(leaning * (v - Vec3(0.0, 0.0, seat_height)));
    const Vec3 next = stretch_to(leant, spec.size_m);
    shape = next.asDiagonal() * leaning;
    const bool settled = (next - scale).norm() <= 1e-12 * scale.norm();
    scale = next;
    if (settled || spec.tilt_deg == 0.0) break;
  }
  const Vec3 origin(0.0, 0.0, seat_height);
  const auto place = [shape, origin](const Vec3& p) { return Vec3(shape * (p - origin)); };
  for (Vec3& v : rock.body.vertices) v = place(v);
  rock.sectors = b.rim.size();
  rock.seat = [place, seat, radii = b.rim_radius](std::size_t i, double factor) {
    const double a = kTurn * static_cast<double>(i) / static_cast<double>(radii.size());
    const double x = factor * radii[i] * std::cos(a), y = factor * radii[i] * std::sin(a);
    return place({x, y, seat.at(x, y)});
  };
  for (Vec3& p : b.rim) p = place(p);
  rock.rim.push_back(std::move(b.rim));
  for (Ring3& ring : b.bearing) {
    for (Vec3& p : ring) p = place(p);
    rock.bearing.push_back(std::move(ring));
  }
  return rock;
}

}  // namespace cairn::simulation
