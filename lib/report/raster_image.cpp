#include "report/raster_image.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "base/angle.hpp"
#include "report/base64.hpp"
#include "report/deflate.hpp"
#include "report/palette.hpp"

namespace cairn::report {
namespace {

constexpr std::uint8_t kClear = 255;  // palette entry of cells without data
constexpr std::size_t kShades = 255;

std::size_t block_size(const geometry::GridGeometry& g, std::size_t max_px) {
  const std::size_t longer = std::max(g.columns, g.rows);
  return max_px == 0 ? 1 : (longer + max_px - 1) / max_px;
}

geometry::GridGeometry shrunk_geometry(const geometry::GridGeometry& g, std::size_t block) {
  return {g.west, g.north, g.cell * static_cast<double>(block), (g.columns + block - 1) / block,
          (g.rows + block - 1) / block};
}

// An image of one index a cell, by a function from value to index.
template <typename Index>
IndexedImage indexed(const geometry::Grid<float>& grid, std::vector<Rgba> palette, Index&& index) {
  IndexedImage image{grid.geometry.columns, grid.geometry.rows, std::move(palette), {}};
  image.pixels.reserve(grid.values.size());
  for (const float v : grid.values) image.pixels.push_back(std::isfinite(v) ? index(static_cast<double>(v)) : kClear);
  return image;
}

template <typename Ramp>
std::vector<Rgba> ramp_palette(Ramp&& colour) {
  std::vector<Rgba> palette;
  for (std::size_t i = 0; i < kShades; ++i)
    palette.push_back(colour(static_cast<double>(i) / static_cast<double>(kShades - 1)));
  palette.push_back({0, 0, 0, 0});
  return palette;
}

std::uint8_t shade_index(double t) {
  return static_cast<std::uint8_t>(std::lround(std::clamp(t, 0.0, 1.0) * static_cast<double>(kShades - 1)));
}

}  // namespace

geometry::Grid<float> shrunk(const geometry::Grid<float>& grid, std::size_t max_px, Merge merge) {
  const std::size_t block = block_size(grid.geometry, max_px);
  if (block <= 1) return grid;
  geometry::Grid<float> out(shrunk_geometry(grid.geometry, block), std::numeric_limits<float>::quiet_NaN());
  for (std::size_t r = 0; r < out.geometry.rows; ++r) {
    for (std::size_t c = 0; c < out.geometry.columns; ++c) {
      double sum = 0.0, top = -std::numeric_limits<double>::infinity();
      std::size_t n = 0;
      for (std::size_t y = r * block; y < std::min((r + 1) * block, grid.geometry.rows); ++y) {
        for (std::size_t x = c * block; x < std::min((c + 1) * block, grid.geometry.columns); ++x) {
          const auto v = static_cast<double>(grid.at(y, x));
          if (!std::isfinite(v)) continue;
          sum += v;
          top = std::max(top, v);
          ++n;
        }
      }
      if (n > 0) out.at(r, c) = static_cast<float>(merge == Merge::mean ? sum / static_cast<double>(n) : top);
    }
  }
  return out;
}

std::optional<ValueRange> quantile_range(const geometry::Grid<float>& grid, double lo, double hi) {
  std::vector<float> values;
  values.reserve(grid.values.size());
  for (const float v : grid.values)
    if (std::isfinite(v)) values.push_back(v);
  if (values.empty()) return std::nullopt;
  const auto rank = [&](double q) {
    const auto i = static_cast<std::size_t>(std::lround(q * static_cast<double>(values.size() - 1)));
    std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(i), values.end());
    return static_cast<double>(values[i]);
  };
  const double low = rank(lo);
  return ValueRange{low, rank(hi)};
}

std::optional<ValueRange> value_range(const geometry::Grid<float>& grid) {
  return quantile_range(grid, 0.0, 1.0);
}

IndexedImage hillshade(const geometry::Grid<float>& heights, double sun_azimuth_deg, double sun_altitude_deg) {
  const geometry::GridGeometry& g = heights.geometry;
  const double azimuth = base::deg_to_rad(sun_azimuth_deg), altitude = base::deg_to_rad(sun_altitude_deg);
  const double sun_e = std::cos(altitude) * std::sin(azimuth), sun_n = std::cos(altitude) * std::cos(azimuth);
  const double sun_u = std::sin(altitude);
  IndexedImage image{g.columns, g.rows, {}, std::vector<std::uint8_t>(g.cells(), kClear)};
  image.palette = ramp_palette([](double t) {
    const auto grey = static_cast<std::uint8_t>(std::lround(40.0 + 215.0 * t));
    return Rgba{grey, grey, grey, 255};
  });
  for (std::size_t r = 0; r < g.rows; ++r) {
    for (std::size_t c = 0; c < g.columns; ++c) {
      const float own = heights.at(r, c);
      if (!std::isfinite(own)) continue;
      const auto z = [&](std::ptrdiff_t dr, std::ptrdiff_t dc) {
        const std::ptrdiff_t y = static_cast<std::ptrdiff_t>(r) + dr, x = static_cast<std::ptrdiff_t>(c) + dc;
        if (y < 0 || x < 0 || y >= static_cast<std::ptrdiff_t>(g.rows) || x >= static_cast<std::ptrdiff_t>(g.columns))
          return static_cast<double>(own);
        const float v = heights.at(static_cast<std::size_t>(y), static_cast<std::size_t>(x));
        return static_cast<double>(std::isfinite(v) ? v : own);
      };
      const double east = (z(-1, 1) + 2 * z(0, 1) + z(1, 1) - z(-1, -1) - 2 * z(0, -1) - z(1, -1)) / (8 * g.cell);
      const double north = (z(-1, -1) + 2 * z(-1, 0) + z(-1, 1) - z(1, -1) - 2 * z(1, 0) - z(1, 1)) / (8 * g.cell);
      const double cosine = (sun_u - east * sun_e - north * sun_n) / std::sqrt(1.0 + east * east + north * north);
      image.pixels[r * g.columns + c] = shade_index(std::max(0.0, cosine));
    }
  }
  return image;
}

IndexedImage height_tint(const geometry::Grid<float>& heights, const ValueRange& range) {
  const double span = std::max(range.hi - range.lo, 1e-6);
  return indexed(heights, ramp_palette(height_ramp), [&](double v) { return shade_index((v - range.lo) / span); });
}

IndexedImage view_counts(const geometry::Grid<float>& views, int max_views) {
  std::vector<Rgba> palette{{213, 94, 0, 255}};
  for (int i = 1; i <= max_views; ++i) palette.push_back(cividis(max_views < 2 ? 1.0 : (i - 1.0) / (max_views - 1.0)));
  palette.resize(256, {0, 0, 0, 0});
  return indexed(views, std::move(palette), [&](double v) {
    return static_cast<std::uint8_t>(std::clamp(std::lround(v), 0L, static_cast<long>(max_views)));
  });
}

IndexedImage cost_picture(const geometry::Grid<float>& cost, double top, std::optional<double> lethal) {
  std::vector<Rgba> palette = ramp_palette(cost_ramp);
  palette[0] = {255, 255, 255, 0};
  palette[kShades - 1] = {38, 12, 56, 255};
  return indexed(cost, std::move(palette), [&](double v) -> std::uint8_t {
    if (v <= 0.0) return 0;
    if (lethal && v >= *lethal) return kShades - 1;
    return std::clamp<std::uint8_t>(shade_index(v / std::max(top, 1e-9)), 1, kShades - 2);
  });
}

RgbaImage colour_picture(const ColourView& colours, std::size_t max_px) {
  const std::size_t block = block_size(colours.geometry, max_px);
  const geometry::GridGeometry g = shrunk_geometry(colours.geometry, block);
  RgbaImage image{g.columns, g.rows, std::vector<Rgba>(g.cells(), Rgba{0, 0, 0, 0})};
  for (std::size_t r = 0; r < g.rows; ++r) {
    for (std::size_t c = 0; c < g.columns; ++c) {
      std::array<std::size_t, 3> sum{};
      std::size_t n = 0;
      for (std::size_t y = r * block; y < std::min((r + 1) * block, colours.geometry.rows); ++y) {
        for (std::size_t x = c * block; x < std::min((c + 1) * block, colours.geometry.columns); ++x) {
          const std::size_t i = y * colours.geometry.columns + x;
          if (colours.mask[i] == 0) continue;
          for (std::size_t k = 0; k < 3; ++k) sum[k] += colours.colours[i][k];
          ++n;
        }
      }
      if (n == 0) continue;
      Rgba& pixel = image.pixels[r * g.columns + c];
      for (std::size_t k = 0; k < 3; ++k) pixel[k] = static_cast<std::uint8_t>((sum[k] + n / 2) / n);
      pixel[3] = 255;
    }
  }
  return image;
}

PackedGrid packed(const geometry::Grid<float>& grid, std::size_t max_px, Merge merge) {
  const geometry::Grid<float> small = shrunk(grid, max_px, merge);
  PackedGrid out{small.geometry, 0.0, 1.0, {}};
  const std::optional<ValueRange> range = value_range(small);
  if (range) {
    out.offset = range->lo;
    // Whole numbers stay exact; heights get a step that fits the range, a millimetre at best.
    const bool whole = std::all_of(small.values.begin(), small.values.end(),
                                   [](float v) { return !std::isfinite(v) || v == std::round(v); });
    constexpr double kMaxCount = 65534.0;
    out.step = whole && range->hi - range->lo <= kMaxCount ? 1.0 : std::max(0.001, (range->hi - range->lo) / kMaxCount);
  }
  std::string bytes;
  bytes.reserve(small.values.size() * 2);
  for (const float v : small.values) {
    const unsigned long n =
        std::isfinite(v) ? static_cast<unsigned long>(std::lround((static_cast<double>(v) - out.offset) / out.step))
                         : 65535UL;
    bytes += static_cast<char>(n & 0xFFU);
    bytes += static_cast<char>(n >> 8 & 0xFFU);
  }
  out.base64 = base64(zlib_compressed(bytes));
  return out;
}

}  // namespace cairn::report
