#include "simulation/sampled_cloud.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "base/angle.hpp"
#include "base/error.hpp"
#include "base/parallel.hpp"
#include "camera/projection.hpp"
#include "simulation/noise.hpp"

namespace cairn::simulation {
namespace {

using geometry::Box3;
using geometry::Vec3;

constexpr double kOversampling = 4.0;  // candidates a square of the spacing, of which the thinning keeps one
constexpr double kOpenAir = 60.0;      // m without a hit: the ray has left the scene
constexpr double kLift = 1e-3;         // m off the surface, so that it does not block itself
constexpr std::size_t kGrain = 4096;
constexpr std::uint32_t kNoTarget = 0xffffffffU;

struct Candidate {
  std::array<std::int32_t, 3> cube;
  std::uint32_t triangle = 0;
  std::uint64_t rank = 0;  // of those in one cube the lowest stays
  Vec3 position;
};

bool near_any(const Vec3& p, const std::vector<Box3>& boxes, double margin) {
  for (const Box3& box : boxes)
    if (p.x() >= box.min.x() - margin && p.x() <= box.max.x() + margin && p.y() >= box.min.y() - margin &&
        p.y() <= box.max.y() + margin)
      return true;
  return false;
}

std::vector<Box3> rock_boxes(const RenderScene& scene) {
  std::vector<Box3> boxes(scene.bodies().size());
  const auto& mesh = scene.mesh();
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const std::size_t b = scene.body_of(static_cast<std::uint32_t>(i));
    const auto part = scene.bodies()[b].part;
    if (part != SurfacePart::rock && part != SurfacePart::pedestal) continue;
    for (const auto v : mesh.triangles[i]) boxes[b].extend(mesh.vertices[v]);
  }
  boxes.erase(std::remove_if(boxes.begin(), boxes.end(), [](const Box3& box) { return box.empty(); }), boxes.end());
  return boxes;
}

// Uniform over the surface, thinned to one point a cube.
std::vector<Candidate> even_points(const RenderScene& scene, const CloudOptions& options, base::RunContext& ctx) {
  const auto& mesh = scene.mesh();
  const std::size_t count = mesh.triangles.size();
  const auto boxes = options.margin_m > 0.0 ? rock_boxes(scene) : std::vector<Box3>{};
  const double density = kOversampling / (options.spacing_m * options.spacing_m);
  std::vector<double> expected(count, 0.0);
  base::parallel_for(count, kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const double area = mesh.area_vector(i).norm();
      Box3 box;
      for (const auto v : mesh.triangles[i]) box.extend(mesh.vertices[v]);
      const double reach = options.margin_m + 0.5 * box.size().norm();
      if (!std::isfinite(area) || (options.margin_m > 0.0 && !near_any(box.centre(), boxes, reach))) continue;
      expected[i] = area * density;
    }
  });
  const double total = base::deterministic_sum(expected);
  constexpr double kMostSamples = 4e8;
  if (total > kMostSamples)
    throw base::Error(base::ErrorCode::resource_exhausted, "the cloud would need too many samples")
        .found(std::to_string(total))
        .allowed("at most 4e8")
        .hint("Give a larger spacing, or a margin round the rocks");
  ctx.check_memory(static_cast<std::uint64_t>(1.3 * total * sizeof(Candidate)), "samples of the surface");
  Box3 bounds;
  for (const Vec3& v : mesh.vertices) bounds.extend(v);

  std::vector<std::size_t> first(count + 1, 0);
  for (std::size_t i = 0; i < count; ++i) {
    std::size_t points = 0;
    if (expected[i] > 0.0) points = static_cast<std::size_t>(expected[i] + ctx.random("cloud_count", i).uniform());
    first[i + 1] = first[i] + points;
  }
  std::vector<Candidate> samples(first.back());
  base::parallel_for(count, kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      if (first[i] == first[i + 1]) continue;
      auto random = ctx.random("cloud", i);
      const auto& t = mesh.triangles[i];
      const Vec3 &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
      for (std::size_t k = first[i]; k < first[i + 1]; ++k) {
        const double r = std::sqrt(random.uniform()), s = random.uniform();
        samples[k].position = (1.0 - r) * a + r * (1.0 - s) * b + r * s * c;
        samples[k].triangle = static_cast<std::uint32_t>(i);
        samples[k].rank = random.bits();
        const Vec3 cube = (samples[k].position - bounds.min) / options.spacing_m;
        for (std::size_t d = 0; d < 3; ++d)
          samples[k].cube[d] = static_cast<std::int32_t>(cube[static_cast<Eigen::Index>(d)]);
      }
    }
  });
  if (options.margin_m > 0.0)
    std::erase_if(samples, [&](const Candidate& s) { return !near_any(s.position, boxes, options.margin_m); });
  std::sort(samples.begin(), samples.end(), [](const Candidate& a, const Candidate& b) {
    return a.cube != b.cube ? a.cube < b.cube : a.rank < b.rank;
  });
  // Two surfaces that share a cube (a rock and what it stands on) both keep a point.
  std::vector<Candidate> kept;
  for (std::size_t i = 0; i < samples.size();) {
    std::size_t j = i;
    const std::size_t mine = kept.size();
    for (; j < samples.size() && samples[j].cube == samples[i].cube; ++j) {
      const std::size_t body = scene.body_of(samples[j].triangle);
      const bool taken = std::any_of(kept.begin() + static_cast<std::ptrdiff_t>(mine), kept.end(),
                                     [&](const Candidate& k) { return scene.body_of(k.triangle) == body; });
      if (!taken) kept.push_back(samples[j]);
    }
    i = j;
  }
  return kept;
}

Vec3 normal_of(const RenderScene& scene, const Candidate& point) {
  return scene.mesh().area_vector(point.triangle).normalized();
}

// Directions over the hemisphere about a normal: eight a batch, three batches. A way is open where it leads to the
// sky, or, downwards, to the outer side of another surface with room for a camera between. Under the ground every
// way ends at a surface's inner side, or falls out of the scene.
std::vector<std::uint8_t> exposed(const RenderScene& scene, const std::vector<Candidate>& points) {
  constexpr std::size_t kBatch = 8, kBatches = 3;
  constexpr double kRoom = 0.5;   // m
  constexpr double kSteep = 0.2;  // sine of an elevation; flatter ways may leave below the ground's edge
  std::vector<std::uint8_t> open(points.size(), 0);
  base::parallel_for(points.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    std::vector<geometry::Ray> rays(kBatch);
    for (std::size_t i = begin; i < end; ++i) {
      const Vec3 n = normal_of(scene, points[i]);
      const Vec3 side = (std::abs(n.x()) < 0.8 ? n.cross(Vec3::UnitX()) : n.cross(Vec3::UnitY())).normalized();
      const Vec3 other = n.cross(side), from = points[i].position + kLift * n;
      for (std::size_t batch = 0; batch < kBatches && open[i] == 0; ++batch) {
        for (std::size_t k = 0; k < kBatch; ++k) {
          const std::size_t index = kBatches * k + batch;
          const double r = std::sqrt((static_cast<double>(index) + 0.5) / (kBatch * kBatches));
          const double a = static_cast<double>(index) * std::numbers::pi * (3.0 - std::sqrt(5.0));
          rays[k] = {from, r * std::cos(a) * side + r * std::sin(a) * other + std::sqrt(1.0 - r * r) * n};
        }
        const auto hits = scene.rays().cast(rays, kOpenAir);
        for (std::size_t k = 0; k < kBatch && open[i] == 0; ++k) {
          const Vec3& direction = rays[k].direction;
          const bool way = hits[k].hit() ? hits[k].distance > kRoom &&
                                               scene.mesh().area_vector(hits[k].triangle).dot(direction) < 0.0
                                         : direction.z() > kSteep;
          open[i] = way ? 1 : 0;
        }
      }
    }
  });
  return open;
}

std::vector<std::uint8_t> seen(const RenderScene& scene, std::span<const View> views,
                               const std::vector<Candidate>& points, const CloudOptions& options) {
  std::vector<std::uint8_t> enough(points.size(), 0);
  const double least_cosine = std::cos(base::deg_to_rad(options.max_incidence_deg));
  base::parallel_for(points.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    std::vector<std::int64_t> count(end - begin, 0);
    std::vector<std::size_t> asked;
    std::vector<Vec3> ends;
    std::vector<std::uint8_t> blocked;
    for (const View& view : views) {
      asked.clear();
      ends.clear();
      const Vec3& eye = view.T_world_camera.translation;
      for (std::size_t i = begin; i < end; ++i) {
        if (count[i - begin] >= options.min_views) continue;
        const Vec3 n = normal_of(scene, points[i]), to_eye = eye - points[i].position;
        const double distance = to_eye.norm();
        if (distance > options.max_range_m || n.dot(to_eye) < least_cosine * distance) continue;
        const auto pixel = camera::project_world(view.camera, view.T_world_camera, points[i].position);
        if (!pixel || !camera::inside_image(view.camera, *pixel)) continue;
        asked.push_back(i - begin);
        ends.push_back(points[i].position + kLift * n);
      }
      blocked.assign(ends.size(), 0);
      scene.rays().blocked_from(eye, ends, blocked, 1e-5);
      for (std::size_t k = 0; k < asked.size(); ++k) count[asked[k]] += blocked[k] == 0 ? 1 : 0;
    }
    for (std::size_t i = begin; i < end; ++i) enough[i] = count[i - begin] >= options.min_views ? 1 : 0;
  });
  return enough;
}

double distance_to_ring(const Vec3& p, const std::vector<Vec3>& ring) {
  double best = 1e300;
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const Vec3 &a = ring[i], &b = ring[(i + 1) % ring.size()];
    const double length = (b - a).squaredNorm();
    const double t = length > 0.0 ? std::clamp((p - a).dot(b - a) / length, 0.0, 1.0) : 0.0;
    best = std::min(best, (p - a - t * (b - a)).squaredNorm());
  }
  return std::sqrt(best);
}

struct Rim {
  std::int64_t object = -1;
  Box3 box;
  const std::vector<Vec3>* ring = nullptr;
};

std::vector<Rim> rims_of(const RenderScene& scene, double width) {
  std::vector<Rim> rims;
  for (const RenderBody& body : scene.bodies()) {
    if (body.part != SurfacePart::rock) continue;
    for (const auto& ring : body.contact_rim) {
      if (ring.empty()) continue;
      Rim rim{body.object, {}, &ring};
      for (const Vec3& p : ring) rim.box.extend(p);
      rim.box.min -= Vec3::Constant(width);
      rim.box.max += Vec3::Constant(width);
      rims.push_back(rim);
    }
  }
  return rims;
}

SurfacePart part_at(const Vec3& p, const RenderBody& body, const std::vector<Rim>& rims, double width) {
  if (body.part != SurfacePart::rock && body.part != SurfacePart::pedestal) return body.part;
  for (const Rim& rim : rims) {
    if (rim.object != body.object || (p.array() < rim.box.min.array()).any() || (p.array() > rim.box.max.array()).any())
      continue;
    if (distance_to_ring(p, *rim.ring) <= width) return SurfacePart::basal_contact;
  }
  return body.part;
}

std::uint16_t colour16(double linear) {
  return static_cast<std::uint16_t>(std::lround(65535.0 * srgb_from_linear(std::clamp(linear, 0.0, 1.0))));
}

}  // namespace

void CloudOptions::visit(base::OptionVisitor& visitor) {
  visitor.real("spacing-m", spacing_m, 0.001, 10.0, "distance of neighbouring points [m]");
  visitor.real("noise-m", noise_m, 0.0, 1.0, "standard deviation along the normal [m]");
  visitor.real("waviness-m", waviness_m, 0.0, 1.0, "amplitude of the surface's correlated error [m]");
  visitor.real("waviness-length-m", waviness_length_m, 0.001, 100.0, "length over which that error is correlated [m]");
  visitor.real("outlier-share", outlier_share, 0.0, 0.5, "points far off the surface");
  visitor.real("contact-width-m", contact_width_m, 0.0, 1.0, "half width of the basal contact [m]; 0 = 1.5 spacings");
  visitor.real("margin-m", margin_m, 0.0, 1e5, "only points this near to a rock or pedestal [m]; 0 = all");
  visitor.integer("min-views", min_views, 1, 100, "views that must see a point");
  visitor.real("max-incidence-deg", max_incidence_deg, 1.0, 90.0, "largest angle of a sight line from the normal");
  visitor.real("max-range-m", max_range_m, 0.1, 1e5, "longest sight line [m]");
}

geometry::PointCloud sample_cloud(const RenderScene& scene, std::span<const View> views, const CloudOptions& options,
                                  base::RunContext& ctx) {
  CloudOptions checked = options;
  base::validate(base::bind_options(checked), "cloud");
  auto points = even_points(scene, options, ctx);
  const auto wanted = views.empty() ? exposed(scene, points) : seen(scene, views, points, options);
  std::size_t count = 0;
  for (std::size_t i = 0; i < points.size(); ++i)
    if (wanted[i] != 0) points[count++] = points[i];
  points.resize(count);

  const double width = options.contact_width_m > 0.0 ? options.contact_width_m : 1.5 * options.spacing_m;
  const auto rims = rims_of(scene, width);
  const std::uint64_t wave_seed = ctx.random("cloud_waviness", 0).bits();
  geometry::PointCloud cloud;
  cloud.positions.resize(count);
  cloud.colours.resize(count);
  std::vector<double> labels(count), targets(count);
  base::parallel_for(count, kGrain, [&](std::size_t begin, std::size_t end) {
    std::vector<visibility::Segment> to_sun;
    for (std::size_t i = begin; i < end; ++i) {
      const Vec3 from = points[i].position + 2.0 * kLift * normal_of(scene, points[i]);
      to_sun.push_back({from, from + kOpenAir * scene.to_sun()});
    }
    const auto shadow = scene.rays().blocked(to_sun, 0.0);
    for (std::size_t i = begin; i < end; ++i) {
      const auto surface = scene.at(points[i].triangle, points[i].position);
      const bool sunlit = shadow[i - begin] == 0 && surface.face_normal.dot(scene.to_sun()) > 0.0;
      const Colour colour = scene.shade(surface, options.spacing_m, sunlit);
      for (std::size_t k = 0; k < 3; ++k) cloud.colours[i][k] = colour16(colour[static_cast<Eigen::Index>(k)]);
      labels[i] = static_cast<double>(part_at(points[i].position, *surface.body, rims, width));
      const bool belongs = surface.body->object >= 0 &&
                           (surface.body->part == SurfacePart::rock || surface.body->part == SurfacePart::pedestal);
      targets[i] = belongs ? static_cast<double>(surface.body->object) : static_cast<double>(kNoTarget);
      auto random = ctx.random("cloud_noise", i);
      double off = options.noise_m * random.normal();
      if (options.waviness_m > 0.0)
        off += 2.5 * options.waviness_m *
               value_noise(points[i].position / options.waviness_length_m, wave_seed);  // its deviation is 0.4 or less
      if (random.uniform() < options.outlier_share) off += random.uniform(-0.5, 0.5);
      cloud.positions[i] = points[i].position + off * surface.face_normal;
    }
  });
  cloud.add_scalar("label", geometry::ScalarType::u8, "0 none 1 terrain 2 rock 3 pedest 4 contact").values =
      std::move(labels);
  cloud.add_scalar("target_id", geometry::ScalarType::u32, "rock instance; 4294967295 none").values =
      std::move(targets);
  return cloud;
}

}  // namespace cairn::simulation
