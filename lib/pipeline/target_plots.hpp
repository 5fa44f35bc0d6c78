// How a target's points gathered, as a picture.
#pragma once

#include <string>

#include "survey/target.hpp"

namespace cairn::pipeline {

// The two thresholds that the curves are compared with.
struct PlotThresholds {
  double entropy_nats = 3.0;
  double divergence = 0.01;
};

// SVG, 640 x 420: differential entropy (A.4) over the keyframes above, divergence (A.5, logarithmic) below, thresholds
// dashed, the stages the target entered as vertical lines. Divergences of 0 are drawn at the lower edge. Valid for any
// target, empty histories too.
[[nodiscard]] std::string history_plot(const survey::Target& target, const PlotThresholds& thresholds);

}  // namespace cairn::pipeline
