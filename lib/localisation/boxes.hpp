// Detections made ready for the points filter, frame by frame.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "base/reject.hpp"
#include "localisation/options.hpp"
#include "localisation/view.hpp"
#include "survey/survey.hpp"

namespace cairn::localisation {

// A frame with its ideal camera and how well its pose is known.
struct FrameView {
  survey::FrameId id;
  const survey::Camera* camera = nullptr;
  View view;
  double sigma_xy_m = 0.0, sigma_z_m = 0.0, sigma_rot_rad = 0.0;
  std::vector<std::size_t> boxes;      // whole boxes: indices into PreparedBoxes::boxes
  std::vector<std::size_t> cut_boxes;  // boxes cut by the image border (robust only)
};

struct Box {
  survey::DetectionId id;
  std::size_t frame = 0;                              // index into PreparedBoxes::frames
  std::size_t object_class = 0;                       // index into PreparedBoxes::classes
  geometry::PixelBox ideal;                           // undistorted, px
  geometry::Vec2 centre_px = geometry::Vec2::Zero();  // ideal pixel of the raw box's centre
  geometry::Vec2 sigma_px = geometry::Vec2::Ones();   // of the centre, along u and v
  bool cut = false;  // touches the image border: says where the object is across the border, hardly along it
  double score = 1.0;

  [[nodiscard]] double diagonal_px() const { return std::hypot(ideal.width(), ideal.height()); }
};

struct PreparedBoxes {
  std::vector<FrameView> frames;     // in the order of time, then id; only those with a camera
  std::vector<Box> boxes;            // by frame, then detection id
  std::vector<std::string> classes;  // sorted
  std::vector<base::Reject> rejects;
};

// Reject reasons: unknown_frame, unknown_camera, bad_pose, non_finite_box, zero_area_box, low_score,
// edge (nearer to the border than the margin: the whole body must be inside, A6), cannot_undistort, duplicate_box.
// In robust, boxes at the edge are kept apart as `cut`: the points filter does not use them, the consensus does,
// with a standard deviation of half their longer side across the border they touch.
[[nodiscard]] base::Reject edge_reject(survey::DetectionId id);
[[nodiscard]] PreparedBoxes prepare_boxes(const survey::Survey& survey, const LocateOptions& options);

}  // namespace cairn::localisation
