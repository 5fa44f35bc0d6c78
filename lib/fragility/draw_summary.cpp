#include "fragility/draw_summary.hpp"

#include <algorithm>
#include <cmath>

#include "base/angle.hpp"

namespace cairn::fragility {
namespace {

using base::rad_to_deg;
using Draw = TippingDraw;

double kg(const Draw& d) {
  return d.density_kg_m3 * d.mass.volume;
}
template <int I, int J>
double inertia(const Draw& d) {
  return d.density_kg_m3 * d.mass.inertia_per_density(I, J);
}
template <int I>
double centre(const Draw& d) {
  return d.mass.centre_of_mass[I];
}

constexpr std::array<DrawColumn, 22> kColumns{
    {{"alpha_min_deg", true, [](const Draw& d) { return rad_to_deg(d.alpha); }},
     {"azimuth_deg", true, [](const Draw& d) { return d.azimuth_deg; }},
     {"r_m", true, [](const Draw& d) { return d.r; }},
     {"p_rad_s", true, [](const Draw& d) { return d.p; }},
     {"a_qs_g", true, [](const Draw& d) { return d.a_qs_g; }},
     {"v_min_m_s", true, [](const Draw& d) { return d.v_min; }},
     {"barrier_j", true, [](const Draw& d) { return d.barrier_j; }},
     {"opposite_alpha_deg", true, [](const Draw& d) { return rad_to_deg(d.opposite_alpha); }},
     {"opposite_r_m", true, [](const Draw& d) { return d.opposite_r; }},
     {"opposite_p_rad_s", true, [](const Draw& d) { return d.opposite_p; }},
     {"volume_m3", false, [](const Draw& d) { return d.mass.volume; }},
     {"density_kg_m3", false, [](const Draw& d) { return d.density_kg_m3; }},
     {"mass_kg", false, kg},
     {"com_x_m", false, centre<0>},
     {"com_y_m", false, centre<1>},
     {"com_z_m", false, centre<2>},
     {"inertia_xx_kg_m2", false, inertia<0, 0>},
     {"inertia_yy_kg_m2", false, inertia<1, 1>},
     {"inertia_zz_kg_m2", false, inertia<2, 2>},
     {"inertia_xy_kg_m2", false, inertia<0, 1>},
     {"inertia_xz_kg_m2", false, inertia<0, 2>},
     {"inertia_yz_kg_m2", false, inertia<1, 2>}}};

}  // namespace

std::span<const DrawColumn> draw_columns() {
  return kColumns;
}

survey::Quantiles quantiles(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const auto at = [&](double share) {
    const double position = share * static_cast<double>(values.size() - 1);
    const auto below = static_cast<std::size_t>(position);
    const std::size_t above = std::min(below + 1, values.size() - 1);
    const double rest = position - static_cast<double>(below);
    // Infinite where no push topples: neither a difference nor no share of it may be taken.
    if (rest == 0.0 || values[below] == values[above]) return values[below];
    return values[below] + rest * (values[above] - values[below]);
  };
  return {at(0.05), at(0.16), at(0.50), at(0.84), at(0.95)};
}

survey::TippingUncertainty summary_of(const std::vector<TippingDraw>& draws, double nominal_azimuth_deg,
                                      double friction) {
  survey::TippingUncertainty out;
  out.draws = static_cast<std::int64_t>(draws.size());
  std::int64_t slides = 0;
  out.rose.assign(36, 0.0);
  for (const auto& d : draws) {
    if (!d.standing) continue;
    ++out.standing;
    if (std::tan(d.alpha) > friction) ++slides;
    const double turned = std::fmod(d.azimuth_deg + 360.0, 360.0);
    out.rose[std::min<std::size_t>(static_cast<std::size_t>(turned / 10.0), 35)] += 1.0;
  }
  if (out.standing > 0) {
    out.slides_first_share = static_cast<double>(slides) / static_cast<double>(out.standing);
    for (double& share : out.rose) share /= static_cast<double>(out.standing);
  } else {
    out.rose.clear();
  }
  std::vector<double> values;
  for (const auto& column : kColumns) {
    values.clear();
    for (const auto& d : draws) {
      if (column.needs_standing && !d.standing) continue;
      const double v = column.value(d);
      values.push_back(
          column.name == "azimuth_deg" ? nominal_azimuth_deg + std::remainder(v - nominal_azimuth_deg, 360.0) : v);
    }
    if (!values.empty()) out.scalars.push_back({std::string(column.name), quantiles(values)});
  }
  values.clear();
  for (const auto& d : draws)
    if (d.alpha_bearing) values.push_back(rad_to_deg(*d.alpha_bearing));
  if (!values.empty()) out.scalars.push_back({"alpha_bearing_deg", quantiles(values)});
  return out;
}

std::array<std::vector<double>, 5> azimuth_quantiles(const std::vector<std::vector<double>>& tables) {
  std::array<std::vector<double>, 5> out;
  if (tables.empty()) return out;
  std::vector<double> column(tables.size());
  for (std::size_t k = 0; k < tables.front().size(); ++k) {
    for (std::size_t i = 0; i < tables.size(); ++i) column[i] = tables[i][k];
    const auto q = quantiles(column);
    const std::array<double, 5> levels{q.p05, q.p16, q.p50, q.p84, q.p95};
    for (std::size_t i = 0; i < levels.size(); ++i) out[i].push_back(levels[i]);
  }
  return out;
}

}  // namespace cairn::fragility
