// The audit page of a coverage audit: one HTML file that holds everything it shows.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "geometry/grid.hpp"
#include "report/png.hpp"
#include "report/report_data.hpp"

namespace cairn::report {

// A metric on the ground plan, with what its colours mean.
struct CoverageMap {
  std::string title, note;
  IndexedImage image;
  geometry::GridGeometry geometry;  // local frame; of the image's pixels
  struct Key {
    Rgba colour;
    std::string label;
  };
  std::vector<Key> keys;
};

struct CoverageTargetRow {
  std::string label;
  bool passed = false;
  std::string reasons;
  double height_m = 0.0, width_m = 0.0;
  double wall = 0.0, top = 0.0, basal = 0.0;  // shares, 0..1
  std::optional<double> wall_gsd_mm, basal_gsd_mm, sigma_mm;
  int azimuth_bins = 0;
  bool contact_known = false;
  std::vector<double> wall_by_azimuth, basal_by_azimuth;  // equal sectors clockwise from north; NaN = none
};

struct CoverageFrameRow {
  std::string label;
  std::optional<double> gsd_mm, speed_m_s, exposure_s, blur_px;
};

struct CoveragePage {
  std::string title;
  CoverageView coverage;
  std::optional<double> sides_area_m2, sides_complete;  // walls and undersides
  std::optional<double> block_m;                        // of the interval
  std::vector<CoverageMap> maps;
  std::vector<CoverageTargetRow> targets;
  std::vector<CoverageFrameRow> frames;
  double blur_limit_px = 0.5;
  std::vector<std::string> notes;
};

// UTF-8; loads nothing, runs nothing. All text of the data is escaped; equal data give equal bytes.
[[nodiscard]] std::string render_coverage_page(const CoveragePage& page);

// A picture of a metric: values between lo and hi over cividis (turned round where small is good), others clamped; NaN
// is clear. levels: of the key.
[[nodiscard]] CoverageMap metric_map(const geometry::Grid<float>& values, const std::string& title,
                                     const std::string& note, const std::string& unit, double lo, double hi,
                                     bool small_is_good);

// A picture of counts: 0 in vermilion, then cividis up to `most` and more.
[[nodiscard]] CoverageMap count_map(const geometry::Grid<float>& counts, const std::string& title,
                                    const std::string& note, int most);

}  // namespace cairn::report
