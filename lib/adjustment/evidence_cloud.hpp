// Is the cloud where the poses say the ground is? Colours of the cloud against brightness of the images,
// heights of the cloud against tie points.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "adjustment/cloud_surface.hpp"
#include "base/options.hpp"
#include "geometry/grey_image.hpp"
#include "survey/survey.hpp"

namespace cairn::adjustment {

struct CloudEvidenceOptions {
  std::int64_t places = 60;       // where colours are compared: the most contrasted, spread over the cloud
  double patch_m = 10.0;          // side of the square compared
  double search_m = 2.0;          // largest shift tried, each way
  std::int64_t views = 4;         // images compared at each place, the steepest first
  double min_correlation = 0.45;  // of a patch's best shift
  double max_view_slope = 0.9;    // horizontal run per metre of drop (0.9 = 42 degrees off the vertical)
  std::int64_t min_places = 5;    // fewer good places: no horizontal figure

  void visit(base::OptionVisitor& v) {
    v.integer("cloud-places", places, 1, 10000, "places where cloud colours are compared with images");
    v.real("cloud-patch-m", patch_m, 0.5, 1000.0, "side of the square compared [m]");
    v.real("cloud-search-m", search_m, 0.1, 50.0, "largest horizontal shift tried [m]");
    v.integer("cloud-views", views, 1, 100, "images compared at each place");
    v.real("cloud-min-correlation", min_correlation, 0.1, 0.99, "least correlation of an accepted patch");
    v.real("cloud-max-view-slope", max_view_slope, 0.05, 5.0, "largest obliquity, horizontal run per metre of drop");
    v.integer("cloud-min-places", min_places, 2, 10000, "least number of good places for a horizontal figure");
  }
};

// An image with the frame it belongs to; of any size with the camera's proportions.
struct FrameImage {
  survey::FrameId frame;
  const geometry::GreyImage* image = nullptr;
};

// One comparison: where the cloud's pattern lies in the image's ortho view.
struct CloudMatch {
  survey::FrameId frame;
  geometry::Vec2 place = geometry::Vec2::Zero();    // east, north of the patch, m
  geometry::Vec2 shift_m = geometry::Vec2::Zero();  // cloud - image
  geometry::Vec2 slope = geometry::Vec2::Zero();    // horizontal run of the view per metre of drop
  double correlation = 0.0;
};

struct CloudEvidence {
  std::vector<CloudMatch> matches;  // accepted
  std::size_t places = 0;           // places with at least one accepted match
  std::size_t places_tried = 0;
  // cloud - poses, m. Horizontal: empty when too few places agree. Vertical: from tie points, else from
  // the parallax of the shifts.
  std::optional<geometry::Vec2> horizontal_m;
  geometry::Vec2 horizontal_scatter_m = geometry::Vec2::Zero();  // robust sigma over places
  std::optional<double> vertical_m;
  double vertical_scatter_m = 0.0;  // robust sigma over tie points (or places)
  std::string vertical_by;          // "tie_points", "parallax", ""
  std::size_t tie_points = 0;       // compared with the surface
  double height_slope = 1.0;        // cloud height per tie-point height, robust; 1 when not known
  double mean_correlation = 0.0;
};

// For a patch of the surface each cell is projected into the image (surface height corrected by the
// vertical offset known so far); normalised cross-correlation over all shifts up to search_m, peak by a
// parabola. An offset o = (o_xy, o_z) of the cloud shows in a view of slope t as the shift
//   s = o_xy + o_z t,
// which is solved for o by reweighted least squares (Huber) over all matches; a place is the median of
// its views. The vertical part is replaced by the median of surface - tie point where there are ties.
// Limits: poses good to better than search_m; ground with texture; coloured cloud.
// Cost: places * views * (patch / cell)^2 * (2 search / cell)^2, about 2 s at the defaults.
[[nodiscard]] CloudEvidence cloud_evidence(const survey::Survey& survey, std::span<const FrameImage> images,
                                           const CloudSurface& surface, const CloudEvidenceOptions& options = {});

}  // namespace cairn::adjustment
