#include "fragility/monte_carlo.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "base/angle.hpp"
#include "base/parallel.hpp"
#include "fragility/contact_bounds.hpp"
#include "fragility/contact_noise.hpp"
#include "fragility/draw_summary.hpp"
#include "fragility/surface_moments.hpp"
#include "fragility/tipping.hpp"

namespace cairn::fragility {
namespace {

using geometry::Mat3;
using geometry::Vec3;

// What can be uncertain; each can be switched on alone.
enum Source : unsigned {
  contact_seen = 1,
  contact_inferred = 2,
  cap = 4,
  surface = 8,
  density = 16,
  vertical = 32,
  scale = 64,
  hidden_bearing = 128,
  all_sources = 255
};
constexpr std::array<std::pair<Source, const char*>, 8> kSources{{{contact_seen, "contact_seen"},
                                                                  {contact_inferred, "contact_inferred"},
                                                                  {cap, "cap"},
                                                                  {surface, "surface"},
                                                                  {density, "density"},
                                                                  {vertical, "vertical"},
                                                                  {scale, "scale"},
                                                                  {hidden_bearing, "hidden_bearing"}}};

double perimeter(const std::vector<ContactVertex>& contact) {
  double length = 0.0;
  for (const auto& pad : pads_of(contact)) {
    double of_pad = 0.0;
    (void)arc_lengths(contact, pad, of_pad);
    length += of_pad;
  }
  return length;
}

// Distance along the line to the nearest observed vertex of the pad; half of the pad's length where none was.
std::vector<double> distance_to_seen(const std::vector<ContactVertex>& contact) {
  std::vector<double> out(contact.size(), 0.0);
  for (const auto& pad : pads_of(contact)) {
    double length = 0.0;
    const auto at = arc_lengths(contact, pad, length);
    for (std::size_t i = 0; i < at.size(); ++i) {
      if (contact[pad.first + i].observed) continue;
      double least = 0.5 * length;
      for (std::size_t j = 0; j < at.size(); ++j) {
        if (!contact[pad.first + j].observed) continue;
        const double apart = std::abs(at[i] - at[j]);
        least = std::min(least, std::min(apart, length - apart));
      }
      out[pad.first + i] = least;
    }
  }
  return out;
}

constexpr std::size_t kMostVertices = 160;
// A guess at an unseen stretch is smooth: its error reaches this part of the perimeter.
constexpr double kSlowShare = 6.0;

class Model {
 public:
  Model(const MonteCarloInput& input, const MonteCarloOptions& options)
      : in_(input),
        options_(options),
        sigmas_(contact_sigmas(input, options)),
        noise_(input.contact, options.contact_correlation_m, options.contact_common_share),
        slow_(input.contact, std::max(options.contact_correlation_m, perimeter(input.contact) / kSlowShare),
              options.contact_common_share),
        moments_(moments_of(input.mass)),
        cap_(cap_moments(input.contact, input.mass.centre_of_mass)) {
    radius_ = std::sqrt(cap_.level.area / std::numbers::pi);
    cap_sigma_ = options.cap_sigma_m > 0.0        ? options.cap_sigma_m
                 : input.cap_height_sigma_m > 0.0 ? input.cap_height_sigma_m
                                                  : options.cap_sigma_share * radius_;
    surface_sigma_ = options.surface_sigma_m > 0.0 ? options.surface_sigma_m : 0.5 * input.noise_m;
    const double body_radius = std::cbrt(0.75 * input.mass.volume / std::numbers::pi);
    if (input.mesh != nullptr) {
      const double cell = std::max(options.surface_correlation_m, input.mesh->bounds().size().maxCoeff() / 12.0);
      patches_ = surface_patches(*input.mesh, input.mass.centre_of_mass, cell, input.seen);
    }
    // The cap has an uncertainty of its own.
    const double known = input.mass.area > 0.0 ? cap_.level.area / input.mass.area : 0.0;
    const double elsewhere = std::max(0.0, input.unseen_area_fraction - known);
    for (const auto& patch : patches_) {
      const double share = input.seen.empty() ? elsewhere : patch.unseen / patch.area;
      unseen_sigma_.push_back(options.unseen_sigma_share * body_radius * std::sqrt(share));
    }
    const Eigen::SelfAdjointEigenSolver<Mat3> solver(Mat3(moments_.second / moments_.volume));
    gyration_ = solver.eigenvectors() * solver.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal() *
                solver.eigenvectors().transpose();
  }

  // azimuths: filled with 360 values where the draw stands; nullptr = not wanted.
  [[nodiscard]] TippingDraw draw(base::Random random, unsigned sources, std::vector<double>* azimuths) const {
    const auto on = [sources](Source s) { return (sources & s) != 0U ? 1.0 : 0.0; };
    TippingDraw out;
    auto contact = in_.contact;
    const auto line = noise_.draw(random), unseen = slow_.draw(random);
    double rise = 0.0;
    for (std::size_t i = 0; i < contact.size(); ++i) {
      const auto k = static_cast<Eigen::Index>(i);
      const auto& error = contact[i].observed ? line : unseen;
      const double sigma = sigmas_[i] * on(contact[i].observed ? contact_seen : contact_inferred);
      const double up = options_.contact_vertical_share * sigma * error.up[k];
      contact[i].position += sigma * error.out[k] * noise_.outwards()[i] + Vec3(0.0, 0.0, up);
      rise += up;
    }
    rise /= static_cast<double>(contact.size());
    out.mass = body(random, on(cap), on(surface), rise);
    out.density_kg_m3 = in_.density_kg_m3 * (1.0 + on(density) * options_.density_sigma * random.normal());
    Vec3 gradient;
    for (int i = 0; i < 3; ++i) gradient[i] = random.normal();
    out.mass.centre_of_mass += on(density) * options_.density_gradient * (gyration_ * gradient);
    const double tilt = on(vertical) * base::deg_to_rad(options_.vertical_sigma_deg);
    Vec3 axis = Vec3::Zero();
    axis.x() = tilt * random.normal();
    axis.y() = tilt * random.normal();
    const double size = 1.0 + on(scale) * options_.scale_sigma * random.normal();
    out.bearing_inset = options_.bearing_inset_max * (on(hidden_bearing) > 0.0 ? random.uniform() : 0.5);
    const double angle = axis.norm();
    const Mat3 turn = angle > 0.0 ? Eigen::AngleAxisd(angle, axis / angle).toRotationMatrix() : Mat3(Mat3::Identity());
    const Vec3 centre = out.mass.centre_of_mass;
    for (auto& v : contact) v.position = centre + size * (turn * (v.position - centre));
    out.mass.volume *= size * size * size;
    out.mass.area *= size * size;
    out.mass.inertia_per_density = std::pow(size, 5) * (turn * out.mass.inertia_per_density * turn.transpose());
    tip(out, contact, azimuths);
    return out;
  }

  [[nodiscard]] std::vector<survey::NamedValue> inputs() const {
    double seen = 0.0, inferred = 0.0;
    for (std::size_t i = 0; i < sigmas_.size(); ++i) {
      double& most = in_.contact[i].observed ? seen : inferred;
      most = std::max(most, sigmas_[i]);
    }
    return {{"contact_seen_sigma_max_m", seen},
            {"contact_inferred_sigma_max_m", inferred},
            {"contact_correlation_m", options_.contact_correlation_m},
            {"contact_common_share", options_.contact_common_share},
            {"bearing_inset_max", options_.bearing_inset_max},
            {"cap_sigma_m", cap_sigma_},
            {"surface_sigma_m", surface_sigma_},
            {"density_sigma", options_.density_sigma},
            {"density_gradient", options_.density_gradient},
            {"vertical_sigma_deg", options_.vertical_sigma_deg},
            {"scale_sigma", options_.scale_sigma}};
  }

 private:
  [[nodiscard]] geometry::MassProperties body(base::Random& random, double with_cap, double with_surface,
                                              double rise) const {
    auto moments = moments_;
    // The base goes with the line: a line drawn too high cut off what lies below.
    moments.add(-rise, cap_.level);
    const double height = with_cap * cap_sigma_ * random.normal();
    moments.add(height, cap_.bump);
    moments.first.z() -= 0.5 * height * height * cap_.bump_squared;
    const double common = std::sqrt(options_.surface_offset_share) * random.normal();
    const double local = std::sqrt(1.0 - options_.surface_offset_share);
    for (std::size_t k = 0; k < patches_.size(); ++k) {
      const double seen = surface_sigma_ * (common + local * random.normal());
      moments.add(with_surface * (seen + unseen_sigma_[k] * random.normal()), patches_[k]);
    }
    // To first order only: a base that moves by much of the rock's height may leave moments that no body has.
    if (moments.volume > 0.05 * moments_.volume) {
      const auto mass = mass_of(moments, in_.mass.centre_of_mass, in_.mass.area);
      const auto principal = Eigen::SelfAdjointEigenSolver<Mat3>(mass.inertia_per_density).eigenvalues();
      if (principal[0] > 0.0 && principal[0] + principal[1] >= principal[2]) return mass;
    }
    return mass_of(moments_, in_.mass.centre_of_mass, in_.mass.area);
  }

  void tip(TippingDraw& out, const std::vector<ContactVertex>& contact, std::vector<double>* azimuths) const {
    const auto rim = tipping(out.mass, positions_of(contact), in_.plumb_tolerance_m,
                             azimuths != nullptr ? Azimuths::all : Azimuths::none);
    const auto hidden =
        tipping(out.mass, inset_contact(contact, out.bearing_inset), in_.plumb_tolerance_m, Azimuths::none);
    if (hidden.equilibrium == Equilibrium::stable) out.alpha_bearing = hidden.edges[*hidden.critical].alpha;
    if (rim.equilibrium != Equilibrium::stable) return;
    out.standing = true;
    const Edge& e = rim.edges[*rim.critical];
    out.alpha = e.alpha;
    out.azimuth_deg = e.azimuth_deg;
    out.r = e.r;
    out.p = e.p;
    out.a_qs_g = e.a_qs_g;
    out.v_min = e.v_min;
    out.barrier_j = e.barrier_per_mass * out.mass.volume * out.density_kg_m3;
    const Edge& back = rim.edges[opposite_edge(rim, *rim.critical)];
    out.opposite_alpha = back.alpha;
    out.opposite_r = back.r;
    out.opposite_p = back.p;
    if (azimuths != nullptr) *azimuths = rim.a_qs_g_by_azimuth;
  }

  const MonteCarloInput& in_;
  const MonteCarloOptions& options_;
  std::vector<double> sigmas_;
  ContactNoise noise_, slow_;  // of seen and of inferred stretches
  BodyMoments moments_;
  CapMoments cap_;
  std::vector<SurfaceMoments> patches_;
  std::vector<double> unseen_sigma_;
  Mat3 gyration_ = Mat3::Zero();
  double radius_ = 0.0, cap_sigma_ = 0.0, surface_sigma_ = 0.0;
};

double variance(const std::vector<double>& values) {
  if (values.size() < 2) return 0.0;
  const double count = static_cast<double>(values.size());
  const double mean = base::deterministic_sum(values) / count;
  std::vector<double> squares(values.size());
  for (std::size_t i = 0; i < values.size(); ++i) squares[i] = (values[i] - mean) * (values[i] - mean);
  return base::deterministic_sum(squares) / (count - 1.0);
}

// Each source alone, on the same random numbers.
void fill_shares(const Model& model, const std::function<base::Random(std::uint64_t)>& random, std::size_t draws,
                 survey::TippingUncertainty& summary) {
  std::vector<double> rim(kSources.size()), bearing(kSources.size());
  base::parallel_for(kSources.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t s = begin; s < end; ++s) {
      std::vector<double> on_rim, on_bearing;
      for (std::size_t k = 0; k < draws; ++k) {
        const auto d = model.draw(random(k), kSources[s].first, nullptr);
        if (d.standing) on_rim.push_back(d.alpha);
        if (d.alpha_bearing) on_bearing.push_back(*d.alpha_bearing);
      }
      rim[s] = variance(on_rim);
      bearing[s] = variance(on_bearing);
    }
  });
  const auto shares = [](const std::vector<double>& variances, std::size_t count) {
    std::vector<survey::NamedValue> out;
    double sum = 0.0;
    for (std::size_t s = 0; s < count; ++s) sum += variances[s];
    if (!(sum > 0.0)) return out;
    constexpr double kRounding = 1e-12;  // of a source that does nothing
    for (std::size_t s = 0; s < count; ++s)
      out.push_back({kSources[s].second, variances[s] > kRounding * sum ? variances[s] / sum : 0.0});
    return out;
  };
  summary.variance_shares = shares(rim, kSources.size() - 1);
  summary.variance_shares_bearing = shares(bearing, kSources.size());
}

}  // namespace

void MonteCarloOptions::visit(base::OptionVisitor& visitor) {
  visitor.integer("draws", draws, 0, 1'000'000, "Monte Carlo draws a rock; 0 = none");
  visitor.integer("share-draws", share_draws, 0, 100'000, "draws of each source alone, for what dominates; 0 = none");
  visitor.real("contact-sigma-m", contact_sigma_m, 0.0, 10.0,
               "error across the contact line where it states none; 0 = from spacing, noise and size");
  visitor.real("contact-correlation-m", contact_correlation_m, 0.001, 10.0,
               "an error of the contact line reaches this far along it");
  visitor.real("contact-common-share", contact_common_share, 0.0, 1.0,
               "share of that variance that is the same all round a pad");
  visitor.real("contact-vertical-share", contact_vertical_share, 0.0, 2.0,
               "vertical error of the contact line over its error in plan");
  visitor.real("inferred-sigma-share", inferred_sigma_share, 0.0, 2.0,
               "error of an unseen stretch of contact over its distance to a seen one");
  visitor.real("bearing-inset-max", bearing_inset_max, 0.0, 0.95,
               "hidden bearing: drawn in from the visible rim by 0 .. this share, uniform");
  visitor.real("cap-sigma-m", cap_sigma_m, 0.0, 10.0, "error of the base's height; 0 = as the surface states");
  visitor.real("cap-sigma-share", cap_sigma_share, 0.0, 1.0,
               "the same over the contact's radius, where none is stated");
  visitor.real("surface-sigma-m", surface_sigma_m, 0.0, 10.0, "error of the surface; 0 = half the points' noise");
  visitor.real("surface-offset-share", surface_offset_share, 0.0, 1.0,
               "share of that variance that is the same all over");
  visitor.real("surface-correlation-m", surface_correlation_m, 0.001, 10.0, "an error of the surface reaches this far");
  visitor.real("unseen-sigma-share", unseen_sigma_share, 0.0, 1.0, "error of an unseen surface over the rock's radius");
  visitor.real("density-sigma", density_sigma, 0.0, 0.5, "relative error of the density");
  visitor.real("density-gradient", density_gradient, 0.0, 0.5,
               "relative change of density over a radius of gyration (rind, voids)");
  visitor.real("vertical-sigma-deg", vertical_sigma_deg, 0.0, 20.0, "error of the vertical, each of two axes");
  visitor.real("scale-sigma", scale_sigma, 0.0, 0.2, "relative error of the scale");
}

std::vector<double> contact_sigmas(const MonteCarloInput& input, const MonteCarloOptions& options) {
  const double radius = perimeter(input.contact) / (2.0 * std::numbers::pi);
  constexpr double kLeastShare = 0.01, kMostShare = 0.35;  // of the contact's mean radius
  const double seen = options.contact_sigma_m > 0.0
                          ? options.contact_sigma_m
                          : std::max({input.point_spacing_m, 2.0 * input.noise_m, kLeastShare * radius});
  const auto away = distance_to_seen(input.contact);
  std::vector<double> sigmas;
  for (std::size_t i = 0; i < input.contact.size(); ++i) {
    const auto& v = input.contact[i];
    const double extra = std::min(options.inferred_sigma_share * away[i], kMostShare * radius);
    sigmas.push_back(std::hypot(v.sigma_m > 0.0 ? v.sigma_m : seen, extra));
  }
  return sigmas;
}

MonteCarloResult tipping_draws(const MonteCarloInput& input, const MonteCarloOptions& options,
                               const std::function<base::Random(std::uint64_t)>& random,
                               std::span<const double> edge_azimuths_deg, double nominal_azimuth_deg) {
  MonteCarloResult result;
  if (options.draws == 0 || input.contact.empty()) return result;
  MonteCarloInput in = input;
  const auto pads = pads_of(in.contact).size();
  in.contact =
      densified(in.contact, 0.5 * options.contact_correlation_m, std::max<std::size_t>(8, kMostVertices / pads));
  const Model model(in, options);
  const auto count = static_cast<std::size_t>(options.draws);
  result.draws.resize(count);
  std::vector<std::vector<double>> tables(count);
  constexpr std::size_t kGrain = 16;
  base::parallel_for(count, kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) result.draws[k] = model.draw(random(k), all_sources, &tables[k]);
  });
  std::erase_if(tables, [](const auto& table) { return table.empty(); });
  result.summary = summary_of(result.draws, nominal_azimuth_deg, in.friction);
  result.summary.a_qs_g_by_azimuth = azimuth_quantiles(tables);
  result.summary.inputs = model.inputs();
  if (options.share_draws > 0)
    fill_shares(model, random, std::min(count, static_cast<std::size_t>(options.share_draws)), result.summary);
  result.critical_share.assign(edge_azimuths_deg.size(), 0.0);
  if (edge_azimuths_deg.empty() || result.summary.standing == 0) return result;
  for (const auto& d : result.draws) {
    if (!d.standing) continue;
    std::size_t nearest = 0;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t e = 0; e < edge_azimuths_deg.size(); ++e) {
      const double off = std::abs(std::remainder(d.azimuth_deg - edge_azimuths_deg[e], 360.0));
      if (off < least) least = off, nearest = e;
    }
    result.critical_share[nearest] += 1.0 / static_cast<double>(result.summary.standing);
  }
  return result;
}

}  // namespace cairn::fragility
