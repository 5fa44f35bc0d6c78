#include "localisation/frame_views.hpp"

#include <algorithm>
#include <cmath>

#include "base/angle.hpp"
#include "base/number_text.hpp"

namespace cairn::localisation {
namespace {

constexpr std::size_t kFramesPerJump = 50;
constexpr std::size_t kLeastRun = 8;  // frames: fewer say nothing about what a fall in time means

bool usable_pose(const geometry::RigidTransform& T) {
  return T.rotation.allFinite() && T.translation.allFinite();
}

FrameView frame_view(const survey::Frame& frame, const survey::Camera& camera, const LocateOptions& options) {
  FrameView result;
  result.id = frame.id;
  result.time_ns = frame.time_ns;
  result.camera = &camera;
  result.view = ideal_view(camera, frame.T_world_camera);
  const auto known = [](double sigma) { return std::isfinite(sigma) && sigma > 0.0 ? sigma : 0.0; };
  result.sigma_xy_m = options.pose_sigma_m >= 0.0 ? options.pose_sigma_m : known(frame.sigma_xy_m);
  result.sigma_z_m = options.pose_sigma_m >= 0.0 ? options.pose_sigma_m : known(frame.sigma_z_m);
  result.sigma_rot_rad =
      base::deg_to_rad(options.pose_sigma_deg >= 0.0 ? options.pose_sigma_deg : known(frame.sigma_rot_deg));
  return result;
}

// Sorts; reports clock jumps.
std::size_t put_in_order(std::vector<FrameView>& frames, std::vector<base::Reject>& rejects) {
  std::stable_sort(frames.begin(), frames.end(), [](const auto& a, const auto& b) { return a.id < b.id; });
  std::vector<std::size_t> falls;
  for (std::size_t i = 1; i < frames.size(); ++i)
    if (frames[i].time_ns < frames[i - 1].time_ns) falls.push_back(i);
  if (falls.empty()) return 0;
  if (frames.size() >= kLeastRun && falls.size() <= std::max<std::size_t>(1, frames.size() / kFramesPerJump)) {
    for (const std::size_t i : falls)
      rejects.push_back({"frame " + std::to_string(frames[i].id.value), "clock_jump",
                         "the clock falls by " +
                             base::to_text(1e-9 * static_cast<double>(frames[i - 1].time_ns - frames[i].time_ns)) +
                             " s after frame " + std::to_string(frames[i - 1].id.value) +
                             "; the order of frame ids is kept and the frame is used"});
    return falls.size();
  }
  std::stable_sort(frames.begin(), frames.end(), [](const auto& a, const auto& b) { return a.time_ns < b.time_ns; });
  return 0;
}

}  // namespace

FrameViews frame_views(const survey::Survey& survey, const LocateOptions& options, std::vector<base::Reject>& rejects) {
  FrameViews result;
  for (const auto& frame : survey.frames) {
    const auto* camera = survey.camera(frame.camera);
    const std::string record = "frame " + std::to_string(frame.id.value);
    if (camera == nullptr) {
      result.unusable[frame.id] = "unknown_camera";
      rejects.push_back(
          {record, "unknown_camera", "camera " + std::to_string(frame.camera.value) + " is not in the survey"});
    } else if (!usable_pose(frame.T_world_camera)) {
      result.unusable[frame.id] = "bad_pose";
      rejects.push_back({record, "bad_pose", "the pose is not finite"});
    } else {
      result.frames.push_back(frame_view(frame, *camera, options));
    }
  }
  result.clock_jumps = put_in_order(result.frames, rejects);
  for (std::size_t i = 0; i < result.frames.size(); ++i) result.index[result.frames[i].id] = i;
  return result;
}

}  // namespace cairn::localisation
