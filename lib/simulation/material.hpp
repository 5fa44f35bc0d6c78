// What surfaces look like: colour as a function of the place in space, so that every view shows the same grain.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "geometry/vec.hpp"

namespace cairn::simulation {

// Linear reflectance of red, green and blue, 0..1.
using Colour = geometry::Vec3;

struct Material {
  Colour albedo = Colour::Constant(0.35), second = Colour::Constant(0.25);  // mixed by coarse noise
  double patch_m = 0.8;                                                     // size of the patches of the two colours, m
  double contrast = 0.35;                                                   // of the fine grain's brightness, 0..1
  double grain_m = 0.12;     // size of the coarsest grain, m; down to a sixty-fourth of it
  double relief = 0.5;       // how much the grain bends the normal for shading, 0..1
  double speckle = 0.0;      // share of dark and bright crystals, 0..1
  double speckle_m = 0.012;  // their size, m
  double lichen = 0.0;       // share of the surface under lichen, 0..1
  double stone_m = 0.0;      // cells of strewn stones, the largest of three sizes, m; 0 = none (level ground only)
  double stones = 0.0;       // share of the cells that hold one, 0..1
  Colour stone = Colour::Constant(0.3);
  double strata_m = 0.0;       // thickness of horizontal bands, m; 0 = none
  bool vertex_colours = true;  // a mesh's own colours take the place of both albedos
  std::uint64_t seed = 0;
};

// granite, sandstone, basalt, limestone, soil, gravel, grass, foliage, paint.
[[nodiscard]] const std::vector<std::string>& material_names();
[[nodiscard]] std::optional<Material> material_named(std::string_view name, std::uint64_t seed);

struct SurfaceLook {
  Colour albedo;
  geometry::Vec3 normal;  // unit, bent by the relief
};

// Look of a point [world, m] with unit normal; `base` replaces the material's two colours where it is given.
// `footprint` is the width of a pixel on the surface [m]: finer grain is left out, so that images do not flicker.
[[nodiscard]] SurfaceLook look_at(const Material& material, const geometry::Vec3& point, const geometry::Vec3& normal,
                                  double footprint, const Colour* base);

// 8-bit sRGB code <-> linear reflectance (IEC 61966-2-1).
[[nodiscard]] double linear_from_srgb(double code_0_1);
[[nodiscard]] double srgb_from_linear(double linear);

}  // namespace cairn::simulation
