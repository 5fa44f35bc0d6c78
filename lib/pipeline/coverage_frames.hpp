// What each frame of a coverage audit is good for: its sampling distance, and how far it is blurred by the flight.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "base/run_context.hpp"
#include "pipeline/coverage_views.hpp"
#include "visibility/scene.hpp"

namespace cairn::pipeline {

struct FrameFigures {
  survey::FrameId frame;
  std::string image;
  std::optional<double> range_m;     // along the optical axis to the surface; over a hole to its median height
  std::optional<double> gsd_mm;      // there, square to the axis
  std::optional<double> speed_m_s;   // between the neighbours in time
  std::optional<double> exposure_s;  // of the image's EXIF
  std::optional<double> blur_px;     // speed x exposure / sampling distance: what the flight alone smears
};

// speed: from the nearest frames before and after of known time, at most `kLongestPause` apart; the frames' own times
// decide how good it is (whole seconds over a few seconds: tens of percent).
inline constexpr double kLongestPause = 60.0;  // s
[[nodiscard]] std::vector<FrameFigures> frame_figures(const CoverageViews& views, const std::filesystem::path& folder,
                                                      const visibility::Scene& scene, base::RunContext& ctx);

// frames_coverage.csv: a row a frame.
void write_frame_rows(const std::filesystem::path& path, const std::vector<FrameFigures>& frames);

}  // namespace cairn::pipeline
