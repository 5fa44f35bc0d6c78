#include "simulation/render.hpp"

#include <algorithm>
#include <cmath>
#include <span>

#include "base/parallel.hpp"
#include "base/random.hpp"
#include "camera/projection.hpp"
#include "simulation/noise.hpp"

namespace cairn::simulation {
namespace {

using geometry::Ray;
using geometry::Vec2;
using geometry::Vec3;

std::uint64_t row_key(std::uint64_t frame, std::size_t row) {
  return (frame << 20U) + row;
}

std::uint8_t code(double linear) {
  // A soft shoulder instead of clipping: rocks in full sun keep their grain.
  const double bent = linear < 0.6 ? linear : 0.6 + 0.4 * (1.0 - std::exp(-(linear - 0.6) / 0.4));
  return static_cast<std::uint8_t>(std::clamp(255.0 * srgb_from_linear(std::clamp(bent, 0.0, 1.0)) + 0.5, 0.0, 255.0));
}

// One row of pixels: rays of all its samples, then what they meet.
class Row {
 public:
  Row(const RenderScene& scene, const survey::Camera& camera, const geometry::RigidTransform& T_world_camera,
      const RenderOptions& options)
      : scene_(scene), camera_(camera), T_(T_world_camera), options_(options) {}

  void depth_and_mask(std::size_t row, RenderedFrame& out) {
    cast(row, 0.5, {0.5});
    const auto width = static_cast<std::size_t>(camera_.width_px);
    const Vec3 axis = T_.rotation.col(2);
    for (std::size_t k = 0; k < rays_.size(); ++k) {
      if (!hits_[k].hit()) continue;
      const std::size_t pixel = row * width + pixels_[k];
      out.depth_m[pixel] = static_cast<float>(hits_[k].distance * rays_[k].direction.dot(axis));
      const RenderBody& body = scene_.bodies()[scene_.body_of(hits_[k].triangle)];
      const bool shown = body.object >= 0 && body.part != SurfacePart::pedestal && body.part != SurfacePart::terrain;
      out.instance[pixel] = shown ? static_cast<std::uint16_t>(body.object + 1) : std::uint16_t{0};
    }
  }

  // Adds the light of one line of samples to sums[pixel].
  void light(std::size_t row, double line, std::span<const double> offsets, std::vector<Colour>& sums) {
    cast(row, line, offsets);
    const double pixel_angle = 1.0 / std::max(camera_.fx_px, camera_.fy_px);
    points_.assign(rays_.size(), {});
    sun_.clear();
    for (std::size_t k = 0; k < rays_.size(); ++k) {
      if (!hits_[k].hit()) continue;
      const Ray& ray = rays_[k];
      points_[k] = scene_.at(hits_[k].triangle, ray.origin + hits_[k].distance * ray.direction);
      // A surface met from behind (an open mesh) is lit as its other side.
      if (points_[k].face_normal.dot(ray.direction) > 0.0) {
        points_[k].face_normal *= -1.0;
        points_[k].normal *= -1.0;
      }
      if (!scene_.lighting().shadows) continue;
      const Vec3 from = points_[k].position + (2e-3 + 2e-5 * hits_[k].distance) * points_[k].face_normal;
      sun_.push_back({from, from + kSunReach * scene_.to_sun()});
    }
    const auto blocked = scene_.rays().blocked(sun_, 0.0);
    std::size_t shadow = 0;
    for (std::size_t k = 0; k < rays_.size(); ++k) {
      const Ray& ray = rays_[k];
      Colour seen = scene_.sky(ray.direction);
      if (hits_[k].hit()) {
        const bool sunlit =
            (!scene_.lighting().shadows || blocked[shadow++] == 0) && points_[k].face_normal.dot(scene_.to_sun()) > 0.0;
        const double slant = std::max(0.2, std::abs(points_[k].face_normal.dot(ray.direction)));
        const double footprint = hits_[k].distance * pixel_angle / slant;
        seen = scene_.through_air(scene_.shade(points_[k], footprint, sunlit), ray.direction, hits_[k].distance);
      }
      sums[pixels_[k]] += seen;
    }
  }

 private:
  static constexpr double kSunReach = 400.0;  // m; nothing higher throws a shadow

  void cast(std::size_t row, double line, std::span<const double> offsets) {
    rays_.clear();
    pixels_.clear();
    for (std::size_t column = 0; column < static_cast<std::size_t>(camera_.width_px); ++column)
      for (const double offset : offsets) {
        const auto direction =
            camera::unproject(camera_, Vec2(static_cast<double>(column) + offset, static_cast<double>(row) + line));
        if (!direction) continue;
        rays_.push_back({T_.translation, T_.rotation * *direction});
        pixels_.push_back(column);
      }
    hits_ = scene_.rays().cast(rays_, options_.far_m);
  }
  void cast(std::size_t row, double line, std::initializer_list<double> offsets) {
    cast(row, line, std::span<const double>(offsets.begin(), offsets.size()));
  }

  const RenderScene& scene_;
  const survey::Camera& camera_;
  const geometry::RigidTransform& T_;
  const RenderOptions& options_;
  std::vector<Ray> rays_;
  std::vector<std::size_t> pixels_;  // column of each ray
  std::vector<visibility::Hit> hits_;
  std::vector<RenderScene::SurfacePoint> points_;
  std::vector<visibility::Segment> sun_;
};

}  // namespace

void RenderOptions::visit(base::OptionVisitor& visitor) {
  visitor.integer("samples", samples, 1, 8, "rays along each side of a pixel");
  visitor.flag("image", image, "compute the picture, not only depth and mask");
  visitor.real("far-m", far_m, 0.1, 1e6, "nothing is seen beyond this distance [m]");
  visitor.real("image-noise", image_noise, 0.0, 50.0, "noise of the sensor, standard deviation in grey levels");
}

void DepthNoise::visit(base::OptionVisitor& visitor) {
  visitor.real("quadratic", quadratic, 0.0, 1.0, "standard deviation of a depth z over z^2 [1/m]");
  visitor.real("nearest-m", nearest_m, 0.0, 1e4, "no return nearer than this [m]");
  visitor.real("farthest-m", farthest_m, 0.0, 1e4, "no return beyond this [m]");
  visitor.real("edge-hole", edge_hole, 0.0, 1.0, "chance of no return beside a jump in depth");
  visitor.real("patch-hole", patch_hole, 0.0, 0.5, "share of pixels lost in patches");
}

RenderedFrame render(const RenderScene& scene, const survey::Camera& camera,
                     const geometry::RigidTransform& T_world_camera, const RenderOptions& options, std::uint64_t seed,
                     std::uint64_t frame) {
  RenderOptions checked = options;
  base::validate(base::bind_options(checked), "render");
  RenderedFrame out;
  out.width_px = camera.width_px;
  out.height_px = camera.height_px;
  const auto width = static_cast<std::size_t>(camera.width_px), height = static_cast<std::size_t>(camera.height_px);
  out.depth_m.assign(width * height, 0.0F);
  out.instance.assign(width * height, 0);
  if (options.image) out.rgb.assign(3 * width * height, 0);
  const auto n = static_cast<std::size_t>(options.samples);
  std::vector<double> offsets;
  for (std::size_t i = 0; i < n; ++i) offsets.push_back((static_cast<double>(i) + 0.5) / static_cast<double>(n));
  base::parallel_for(height, 4, [&](std::size_t begin, std::size_t end) {
    Row line(scene, camera, T_world_camera, options);
    std::vector<Colour> sums(width);
    for (std::size_t row = begin; row < end; ++row) {
      line.depth_and_mask(row, out);
      if (!options.image) continue;
      std::fill(sums.begin(), sums.end(), Colour::Zero());
      for (const double offset : offsets) line.light(row, offset, offsets, sums);
      base::Random random(seed, "image_noise", row_key(frame, row));
      for (std::size_t c = 0; c < width; ++c) {
        const double luminance = options.image_noise > 0.0 ? options.image_noise * random.normal() : 0.0;
        for (std::size_t i = 0; i < 3; ++i) {
          double level = code(sums[c][static_cast<Eigen::Index>(i)] / static_cast<double>(n * n));
          if (options.image_noise > 0.0) level += luminance + 0.4 * options.image_noise * random.normal();
          out.rgb[3 * (row * width + c) + i] = static_cast<std::uint8_t>(std::clamp(level + 0.5, 0.0, 255.0));
        }
      }
    }
  });
  return out;
}

void add_depth_noise(RenderedFrame& frame, const DepthNoise& noise, std::uint64_t seed, std::uint64_t frame_number) {
  DepthNoise checked = noise;
  base::validate(base::bind_options(checked), "depth noise");
  const auto width = static_cast<std::size_t>(frame.width_px), height = static_cast<std::size_t>(frame.height_px);
  constexpr double kJump = 0.05, kPatchPixels = 12.0;
  // Level of the patch noise that about `patch_hole` of all pixels exceed: value noise of one octave is near normal
  // with this deviation.
  constexpr double kPatchDeviation = 0.28;
  const double share = std::max(noise.patch_hole, 1e-9);
  const double level = kPatchDeviation * std::sqrt(std::max(0.0, -2.0 * std::log(2.0 * share))) * 0.92;
  const std::uint64_t patch_seed = base::Random(seed, "depth_patches", frame_number).bits();
  const std::vector<float> truth = frame.depth_m;
  base::parallel_for(height, 16, [&](std::size_t begin, std::size_t end) {
    for (std::size_t r = begin; r < end; ++r) {
      base::Random random(seed, "depth_noise", row_key(frame_number, r));
      for (std::size_t c = 0; c < width; ++c) {
        const double error = random.normal(), chance = random.uniform();  // drawn for every pixel: keyed by place
        const double z = static_cast<double>(truth[r * width + c]);
        float& depth = frame.depth_m[r * width + c];
        if (!(z >= noise.nearest_m && z <= noise.farthest_m)) {
          depth = 0.0F;
          continue;
        }
        bool edge = false;
        const auto beside = [&](std::size_t row, std::size_t column) {
          edge |= std::abs(static_cast<double>(truth[row * width + column]) - z) > kJump * z;
        };
        if (r > 0) beside(r - 1, c);
        if (r + 1 < height) beside(r + 1, c);
        if (c > 0) beside(r, c - 1);
        if (c + 1 < width) beside(r, c + 1);
        const Vec3 place(static_cast<double>(c) / kPatchPixels, static_cast<double>(r) / kPatchPixels, 0.5);
        const bool lost =
            (edge && chance < noise.edge_hole) || (noise.patch_hole > 0.0 && value_noise(place, patch_seed) > level);
        const double noisy = z + noise.quadratic * z * z * error;
        depth = lost || !(noisy > 0.0) ? 0.0F : static_cast<float>(noisy);
      }
    }
  });
}

std::vector<std::uint16_t> depth_millimetres(const RenderedFrame& frame) {
  std::vector<std::uint16_t> out(frame.depth_m.size(), 0);
  for (std::size_t i = 0; i < out.size(); ++i) {
    const double mm = std::round(1000.0 * static_cast<double>(frame.depth_m[i]));
    if (mm >= 1.0 && mm <= 65535.0) out[i] = static_cast<std::uint16_t>(mm);
  }
  return out;
}

}  // namespace cairn::simulation
