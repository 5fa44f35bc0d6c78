// Detections made ready for the points filter, frame by frame.
#pragma once

#include <cmath>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/reject.hpp"
#include "localisation/frame_views.hpp"
#include "localisation/options.hpp"
#include "survey/survey.hpp"
#include "survey/tracklet.hpp"

namespace cairn::localisation {

struct Box {
  survey::DetectionId id;                             // invalid: a tracker's prediction (coasted; paper only)
  std::size_t frame = 0;                              // index into PreparedBoxes::frames
  std::size_t object_class = 0;                       // index into PreparedBoxes::classes
  geometry::PixelBox ideal;                           // undistorted, px
  geometry::Vec2 centre_px = geometry::Vec2::Zero();  // ideal pixel of the raw box's centre
  geometry::Vec2 sigma_px = geometry::Vec2::Ones();   // of the centre, along u and v
  bool cut = false;  // touches the image border: says where the object is across the border, hardly along it
  double score = 1.0;
  survey::TrackId track{};  // invalid without tracks

  [[nodiscard]] double diagonal_px() const { return std::hypot(ideal.width(), ideal.height()); }
};

struct PreparedBoxes {
  std::vector<FrameView> frames;     // in the order of the recording; only those with a camera and a pose
  std::vector<Box> boxes;            // by frame, then detection id, then track
  std::vector<std::string> classes;  // sorted
  std::vector<base::Reject> rejects;
  bool video = false;           // frames overlap: a thing is in many in a row. Tracks, or 100 frames, mostly 2 s apart
  bool tracked = false;         // the boxes are those of registered tracks
  std::size_t coasted = 0;      // rows of tracks without a detection
  std::size_t clock_jumps = 0;  // see frame_views
};

using Tracks = std::optional<std::span<const survey::TrackedBox>>;

// Reject reasons: unknown_frame, unknown_camera, bad_pose, clock_jump, non_finite_box, zero_area_box, low_score,
// edge (nearer to the border than the margin: the whole body must be inside, A6), cannot_undistort, duplicate_box.
// In robust, boxes at the edge are kept apart as `cut`: the points filter does not use them, the consensus does,
// with a standard deviation of half their longer side across the border they touch.
//
// With tracks, only registered boxes go on (A5): detections of no track are rejected as `unregistered`, rows that name
// a detection the survey does not have in that frame as `unknown_detection`, second rows of one detection as
// `duplicate_track_row`. paper takes the tracker's boxes, coasted ones too, as the public code does; robust
// takes the detections themselves, and coasted rows, which are evidence of nothing, are only counted.
[[nodiscard]] base::Reject edge_reject(survey::DetectionId id);
[[nodiscard]] PreparedBoxes prepare_boxes(const survey::Survey& survey, const LocateOptions& options,
                                          const Tracks& tracks = std::nullopt);

}  // namespace cairn::localisation
