#include "simulation/material.hpp"

#include <algorithm>
#include <cmath>

#include "simulation/noise.hpp"

namespace cairn::simulation {
namespace {

using geometry::Vec3;

constexpr int kGrainOctaves = 6;

Colour srgb(int red, int green, int blue) {
  return {linear_from_srgb(red / 255.0), linear_from_srgb(green / 255.0), linear_from_srgb(blue / 255.0)};
}

double smooth_between(double lo, double hi, double value) {
  const double t = std::clamp((value - lo) / (hi - lo), 0.0, 1.0);
  return t * t * (3.0 - 2.0 * t);
}

Material look(Colour albedo, Colour second, double patch, double contrast, double grain, double relief) {
  Material m;
  m.albedo = albedo;
  m.second = second;
  m.patch_m = patch;
  m.contrast = contrast;
  m.grain_m = grain;
  m.relief = relief;
  return m;
}

}  // namespace

double linear_from_srgb(double code) {
  return code <= 0.04045 ? code / 12.92 : std::pow((code + 0.055) / 1.055, 2.4);
}

double srgb_from_linear(double linear) {
  return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1.0 / 2.4) - 0.055;
}

const std::vector<std::string>& material_names() {
  static const std::vector<std::string> names = {"granite", "sandstone", "basalt",  "limestone", "soil",
                                                 "gravel",  "grass",     "foliage", "paint"};
  return names;
}

std::optional<Material> material_named(std::string_view name, std::uint64_t seed) {
  Material m;
  if (name == "granite") {
    m = look(srgb(196, 176, 152), srgb(158, 138, 122), 0.7, 0.42, 0.16, 0.6);
    m.speckle = 0.5;
    m.lichen = 0.1;
  } else if (name == "sandstone") {
    m = look(srgb(204, 148, 106), srgb(176, 112, 78), 0.9, 0.3, 0.2, 0.5);
    m.strata_m = 0.16;
    m.lichen = 0.04;
  } else if (name == "basalt") {
    m = look(srgb(98, 94, 92), srgb(74, 70, 70), 0.5, 0.4, 0.1, 0.7);
    m.speckle = 0.3;
    m.lichen = 0.12;
  } else if (name == "limestone") {
    m = look(srgb(206, 202, 190), srgb(172, 166, 152), 0.6, 0.35, 0.14, 0.6);
    m.lichen = 0.08;
  } else if (name == "soil") {
    m = look(srgb(170, 140, 108), srgb(134, 108, 82), 2.4, 0.5, 0.35, 0.55);
    m.speckle = 0.35;
    m.speckle_m = 0.035;
    m.stone_m = 0.22;
    m.stones = 0.3;
    m.stone = srgb(168, 150, 130);
  } else if (name == "gravel") {
    m = look(srgb(156, 148, 138), srgb(120, 112, 104), 1.5, 0.6, 0.12, 0.9);
    m.speckle = 0.6;
    m.speckle_m = 0.03;
    m.stone_m = 0.14;
    m.stones = 0.75;
    m.stone = srgb(150, 144, 138);
  } else if (name == "grass") {
    m = look(srgb(122, 128, 74), srgb(160, 142, 94), 1.8, 0.55, 0.18, 0.8);
    m.stone_m = 0.2;
    m.stones = 0.12;
    m.stone = srgb(150, 144, 130);
  } else if (name == "foliage") {
    m = look(srgb(84, 108, 54), srgb(62, 84, 44), 0.5, 0.6, 0.14, 0.9);
  } else if (name == "paint") {
    m = look(srgb(200, 200, 198), srgb(190, 190, 188), 0.5, 0.06, 0.1, 0.05);
  } else {
    return std::nullopt;
  }
  m.seed = seed;
  return m;
}

SurfaceLook look_at(const Material& m, const Vec3& point, const Vec3& normal, double footprint, const Colour* base) {
  Colour colour;
  if (base != nullptr && m.vertex_colours) {
    colour = *base;
  } else {
    const double patch = filtered_noise(point, m.seed, m.patch_m, footprint, 4, 0.6);
    colour = m.albedo + smooth_between(-0.35, 0.35, patch) * (m.second - m.albedo);
  }
  if (m.strata_m > 0.0) {
    // Beds warp a little; their brightness is a one-dimensional noise of the warped height.
    const double warped = point.z() + 0.6 * m.strata_m * filtered_noise(point, m.seed + 11, 1.3, footprint, 2);
    const double bed = filtered_noise({0.37, 0.71, warped}, m.seed + 12, m.strata_m, footprint, 3, 0.7);
    colour *= 1.0 + 0.45 * bed;
  }
  if (m.lichen > 0.0) {
    const double cover = filtered_noise(point, m.seed + 21, 0.3, footprint, 5, 0.62);
    const double threshold = 0.52 - 1.6 * m.lichen;
    const double share = smooth_between(threshold, threshold + 0.1, cover);
    const bool orange = value_noise(point / 0.9, m.seed + 22) > 0.25;
    static const Colour kOrange = srgb(176, 130, 62), kGrey = srgb(126, 134, 116);
    colour += 0.75 * share * ((orange ? kOrange : kGrey) - colour);
  }
  // Grain, signed square root: flat parts and sharp pits rather than fog.
  const double grain = filtered_noise(point, m.seed + 31, m.grain_m, footprint, kGrainOctaves, 0.72);
  double brightness = 1.0 + m.contrast * std::copysign(std::sqrt(std::abs(grain)), grain);
  if (m.speckle > 0.0) {
    const double crystal = filtered_noise(point, m.seed + 41, m.speckle_m, footprint, 2, 0.5);
    brightness *= 1.0 - 0.75 * m.speckle * smooth_between(0.3, 0.4, crystal);
    brightness *= 1.0 + 0.6 * m.speckle * smooth_between(0.3, 0.4, -crystal);
  }
  colour *= std::max(0.1, brightness);

  Vec3 stone_slope = Vec3::Zero();
  double bare = 1.0;  // share of the ground's own relief that shows
  if (m.stone_m > 0.0 && normal.z() > 0.5) {
    double cell = m.stone_m;
    for (std::uint64_t size = 0; size < 3; ++size, cell *= 0.45) {
      const double carried = smooth_between(0.8, 2.5, 0.4 * cell / std::max(footprint, 1e-9));
      if (!(carried > 0.0)) break;
      const Stone stone = stone_at(point.head<2>(), m.seed + 51 + size, cell, m.stones);
      if (!(stone.height > 0.0)) continue;
      const double share = carried * smooth_between(0.0, 0.25, stone.height);
      const double tone = 1.0 + 0.45 * stone.shade + 0.3 * (brightness - 1.0);
      colour += share * (tone * m.stone - colour);
      stone_slope = 0.8 * share * Vec3(stone.slope.x(), stone.slope.y(), 0.0);
      bare = 1.0 - share;
      break;
    }
  }
  SurfaceLook result{colour.cwiseMax(0.005).cwiseMin(0.95), normal};
  if (m.relief > 0.0) {
    Vec3 slope = filtered_noise_gradient(point, m.seed + 31, m.grain_m, footprint, 4, 0.72);
    slope -= slope.dot(normal) * normal;
    result.normal = (normal - 0.22 * m.relief * bare * slope + stone_slope).normalized();
  }
  return result;
}

}  // namespace cairn::simulation
