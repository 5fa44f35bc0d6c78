#include "fragility/plane_contact.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "base/angle.hpp"
#include "base/error.hpp"
#include "base/parallel.hpp"
#include "fragility/ground_motion.hpp"

namespace cairn::fragility {
namespace {

using geometry::Vec3;

double median_edge(const geometry::TriangleMesh& mesh) {
  std::vector<double> lengths;
  lengths.reserve(3 * mesh.triangles.size());
  for (const auto& t : mesh.triangles)
    for (std::size_t k = 0; k < 3; ++k) lengths.push_back((mesh.vertices[t[k]] - mesh.vertices[t[(k + 1) % 3]]).norm());
  if (lengths.empty()) return 0.0;
  const auto middle = lengths.begin() + static_cast<std::ptrdiff_t>(lengths.size() / 2);
  std::nth_element(lengths.begin(), middle, lengths.end());
  return *middle;
}

double quantile(const std::vector<double>& sorted, double q) {
  if (sorted.empty()) return 0.0;
  const double at = q * static_cast<double>(sorted.size() - 1);
  const auto i = static_cast<std::size_t>(at);
  const double share = at - static_cast<double>(i);
  return i + 1 < sorted.size() ? sorted[i] + share * (sorted[i + 1] - sorted[i]) : sorted[i];
}

}  // namespace

std::optional<PlaneContact> plane_contact(std::span<const Vec3> points, const geometry::MassProperties& mass) {
  const auto pose = resting_pose(points, mass.centre_of_mass);
  if (!pose) return std::nullopt;
  PlaneContact contact{*pose, std::numeric_limits<double>::infinity(), 0.0, 0.0};
  std::array<Vec3, 3> corner;
  for (std::size_t k = 0; k < 3; ++k) corner[k] = pose->turn * (points[pose->facet[k]] - mass.centre_of_mass);
  contact.height = -corner[0].z();
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3 side = corner[(k + 1) % 3] - corner[k];
    // Counter-clockwise from below is clockwise from above: outside lies to the left of the edge.
    const Vec3 normal = Vec3(-side.y(), side.x(), 0.0).normalized();
    const double alpha = std::atan2(corner[k].dot(normal), contact.height);
    if (!(alpha < contact.alpha)) continue;
    contact.alpha = alpha;
    const Vec3 given = pose->turn.transpose() * normal;
    contact.azimuth_deg = base::azimuth_deg(given.x(), given.y());
  }
  return contact;
}

std::optional<RockingProfile> plane_profile(std::span<const Vec3> points, const geometry::MassProperties& mass,
                                            double azimuth_deg) {
  const auto pose = resting_pose(points, mass.centre_of_mass);
  if (!pose) return std::nullopt;
  std::vector<Vec3> turned;
  turned.reserve(points.size());
  for (const auto& p : points) turned.emplace_back(pose->turn * (p - mass.centre_of_mass));
  geometry::MassProperties settled = mass;
  settled.centre_of_mass = Vec3::Zero();
  settled.inertia_per_density = pose->turn * mass.inertia_per_density * pose->turn.transpose();
  const double a = base::deg_to_rad(azimuth_deg);
  const Vec3 along = pose->turn * Vec3(std::sin(a), std::cos(a), 0.0);
  return hull_profile(turned, settled, base::azimuth_deg(along.x(), along.y()));
}

void PulseTestOptions::visit(base::OptionVisitor& visitor) {
  visitor.integer("contact-draws", contact_draws, 1, 10000, "Draws of the contact on the plane");
  visitor.real("vertex-noise-m", vertex_noise_m, -1.0, 1.0,
               "Normal error of every vertex; -1 = a tenth of the median edge");
  visitor.real("pulse-azimuth-deg", azimuth_deg, -1.0, 360.0,
               "Direction of the motion, clockwise from north; -1 = the weakest of the settled body");
  visitor.real("pulse-azimuth-spread-deg", azimuth_spread_deg, 0.0, 180.0,
               "Greatest error of that direction, uniform; 180 = any direction");
}

PulsePrediction predict_pulse_tests(const geometry::TriangleMesh& mesh, const geometry::MassProperties& mass,
                                    std::span<const std::array<double, 2>> pga_and_ratio,
                                    const PulseTestOptions& options, base::RunContext& ctx) {
  const auto contact = plane_contact(mesh.vertices, mass);
  if (!contact)
    throw base::Error(base::ErrorCode::failed_precondition, "the body has no facet to rest on")
        .hint("Check that the mesh is a closed body with z up");
  PulsePrediction out;
  out.contact = *contact;
  out.azimuth_deg = options.azimuth_deg >= 0.0 ? std::fmod(options.azimuth_deg, 360.0) : contact->azimuth_deg;
  constexpr double kMeshing = 0.1;  // of an edge: what a mesh of voxels resolves
  out.vertex_noise_m = options.vertex_noise_m >= 0.0 ? options.vertex_noise_m : kMeshing * median_edge(mesh);
  out.draws = static_cast<std::size_t>(options.contact_draws);

  struct Draw {
    std::optional<RockingProfile> profile;
    double alpha = 0.0;
  };
  std::vector<Draw> draws(out.draws);
  base::parallel_for(out.draws, 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t d = begin; d < end; ++d) {
      ctx.check_stop();
      auto random = ctx.random("plane contact", d);
      std::vector<Vec3> points = mesh.vertices;
      for (auto& p : points)
        for (int k = 0; k < 3; ++k) p[k] += out.vertex_noise_m * random.normal();
      const double share = options.eta_share_max * random.uniform();
      const double beside = options.azimuth_spread_deg * (2.0 * random.uniform() - 1.0);
      auto profile = plane_profile(points, mass, out.azimuth_deg + beside);
      if (!profile) continue;
      const auto angles = toppling_angles(*profile);
      draws[d] = {with_restitution(std::move(*profile), share), std::min(angles.up, -angles.down)};
    }
  });
  std::vector<double> alphas;
  for (const auto& d : draws)
    if (d.profile) alphas.push_back(d.alpha);
  out.unstable_draws = out.draws - alphas.size();
  std::sort(alphas.begin(), alphas.end());
  const double levels[] = {0.05, 0.16, 0.5, 0.84, 0.95};
  for (std::size_t i = 0; i < 5; ++i) out.alpha_quantiles[i] = quantile(alphas, levels[i]);

  out.probability.resize(pga_and_ratio.size());
  base::parallel_for(pga_and_ratio.size(), 4, [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) {
      ctx.check_stop();
      constexpr std::size_t kSamples = 200;
      const auto pulse = one_cosine(pga_and_ratio[t][0] * kGravity, pga_and_ratio[t][1], kSamples);
      std::size_t toppled = 2 * out.unstable_draws;
      for (const auto& d : draws)
        if (d.profile)
          for (const double polarity : {1.0, -1.0})
            toppled +=
                rock(*d.profile, {pulse.acceleration, {}, pulse.dt, polarity, 0.0, 0.0}, options.rocking).overturned
                    ? 1U
                    : 0U;
      out.probability[t] = static_cast<double>(toppled) / static_cast<double>(2 * out.draws);
    }
  });
  return out;
}

}  // namespace cairn::fragility
