// Draws to figures: quantiles, rose, shares.
#pragma once

#include <array>
#include <span>
#include <string_view>
#include <vector>

#include "fragility/monte_carlo.hpp"
#include "survey/rock.hpp"

namespace cairn::fragility {

// Linear between order statistics (Hyndman & Fan 1996, type 7). Precondition: at least one value, all finite.
[[nodiscard]] survey::Quantiles quantiles(std::vector<double> values);

// One scalar of a draw, in the unit of its name.
struct DrawColumn {
  std::string_view name;
  bool needs_standing = false;  // has no value in a draw that does not stand
  double (*value)(const TippingDraw&) = nullptr;
};
// All columns of the draws file and of the quantiles, in order.
[[nodiscard]] std::span<const DrawColumn> draw_columns();

// Scalars, rose and standing count. azimuth_deg is unwrapped about `nominal_azimuth_deg`, so its quantiles may lie
// outside 0..360.
[[nodiscard]] survey::TippingUncertainty summary_of(const std::vector<TippingDraw>& draws, double nominal_azimuth_deg,
                                                    double friction);

// 5, 16, 50, 84, 95 % for each of 360 azimuths; tables: 360 values a standing draw.
[[nodiscard]] std::array<std::vector<double>, 5> azimuth_quantiles(const std::vector<std::vector<double>>& tables);

}  // namespace cairn::fragility
