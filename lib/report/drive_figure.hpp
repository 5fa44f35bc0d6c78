// Drawings of a ground vehicle's drive, as in paper B's figures: paths over a costmap, and the periods between updates.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "geometry/grid.hpp"
#include "geometry/primitives.hpp"

namespace cairn::report {

struct DriveTrack {
  std::string label;   // "" = not in the legend
  std::string colour;  // "#0072b2"
  bool dashed = false;
  std::vector<geometry::Vec2> points;  // local east, north, m
};

struct DriveOutline {
  geometry::Ring ring;  // local east, north, m
  std::string fill;     // "#d55e00"; "none"
  std::string stroke;
};

struct DriveMark {
  geometry::Vec2 position = geometry::Vec2::Zero();
  std::string label;
};

// A picture under everything else, north up.
struct DriveBackground {
  geometry::Vec2 min = geometry::Vec2::Zero(), max = geometry::Vec2::Zero();  // local east, north, m
  std::string type;                                                           // "png", "jpeg"; "" = no picture
  std::string bytes;                                                          // of the file
};

struct DriveFigure {
  std::string title;
  DriveBackground background;
  // Values of ground/costmap.hpp: 1..252 as a ramp, 253 and 254 dark, 255 (unknown) grey; clear where it is 0. Empty =
  // none.
  geometry::Grid<std::uint8_t> cost;
  double cost_opacity = 1.0;
  geometry::Vec2 min = geometry::Vec2::Zero(), max = geometry::Vec2::Zero();  // what is shown where there is no cost
  std::vector<DriveOutline> outlines;                                         // drawn in order
  std::vector<DriveTrack> tracks;
  std::vector<DriveMark> marks;
  double width_px = 860.0;
};

// Throws invalid_argument where nothing is shown.
[[nodiscard]] std::string drive_figure_svg(const DriveFigure& figure);

// Periods between the packets that arrived, against time, with their mean and greatest, and the period that was set.
// times_s, periods_s: one a packet, s; sizes must be equal.
[[nodiscard]] std::string update_periods_svg(const std::string& title, const std::vector<double>& times_s,
                                             const std::vector<double>& periods_s, double set_s);

}  // namespace cairn::report
