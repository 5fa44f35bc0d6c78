#include "localisation/depth_prior.hpp"

#include <algorithm>
#include <cmath>

#include "base/parallel.hpp"
#include "camera/projection.hpp"

namespace cairn::localisation {
namespace {

constexpr double kDefaultNear = 3.0, kDefaultFar = 18.0;  // m, the public code's range (granite)
constexpr std::size_t kFewestTies = 8;                    // fewer say nothing about the spread of depths
constexpr double kTrim = 0.02;                            // of the depths at either end: mismatched ties
constexpr double kFarMargin = 0.05;                       // of the depth
constexpr double kLeastMargin = 1.0;                      // m
constexpr double kNearest = 0.1;                          // m; nothing nearer to a flying camera is worth a point

DepthRange sane(double near_m, double far_m) {
  near_m = std::max(kNearest, near_m);
  return {near_m, std::max(far_m, near_m * 1.01)};
}

}  // namespace

DepthPrior::DepthPrior(const survey::Survey& survey, const PreparedBoxes& prepared, const LocateOptions& options,
                       DepthBound bound)
    : prepared_(prepared), options_(options), bound_(std::move(bound)), ties_(prepared.frames.size()) {
  if (survey.ties.empty() || options.max_depth_m > 0.0) return;
  base::parallel_for(prepared.frames.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t f = begin; f < end; ++f) {
      const FrameView& frame = prepared_.frames[f];
      if (frame.boxes.empty()) continue;
      for (const auto& tie : survey.ties) {
        if (!tie.p_world.allFinite()) continue;
        const auto pixel = frame.view.project(tie.p_world);
        if (pixel && camera::inside_image(*frame.camera, *pixel))
          ties_[f].push_back({*pixel, frame.view.to_camera(tie.p_world).z()});
      }
    }
  });
  any_ties_ = std::any_of(ties_.begin(), ties_.end(), [](const auto& t) { return t.size() >= kFewestTies; });
}

std::optional<DepthRange> DepthPrior::from_ties(const Box& box) const {
  const auto& ties = ties_[box.frame];
  if (ties.size() < kFewestTies) return std::nullopt;
  const auto* camera = prepared_.frames[box.frame].camera;
  const double reach = 0.25 * std::hypot(static_cast<double>(camera->width_px), static_cast<double>(camera->height_px));
  std::vector<double> depths;
  for (const auto& tie : ties)
    if ((tie.pixel - box.centre_px).squaredNorm() <= reach * reach) depths.push_back(tie.depth);
  if (depths.size() < kFewestTies) {
    depths.clear();
    for (const auto& tie : ties) depths.push_back(tie.depth);
  }
  std::sort(depths.begin(), depths.end());
  const auto last = static_cast<double>(depths.size() - 1);
  const double near_m = depths[static_cast<std::size_t>(std::lround(kTrim * last))];
  const double far_m = depths[static_cast<std::size_t>(std::lround((1.0 - kTrim) * last))];
  return sane(near_m - options_.height_above_ground_m, far_m + std::max(kLeastMargin, kFarMargin * far_m));
}

DepthRange DepthPrior::range(const Box& box) const {
  const View& view = prepared_.frames[box.frame].view;
  std::optional<DepthRange> found;
  if (options_.max_depth_m > 0.0) found = sane(options_.min_depth_m, options_.max_depth_m);
  const geometry::Vec3 direction = view.direction(box.centre_px);
  if (!found && bound_) {
    found = bound_(view, direction);
    if (found && !(found->near_m >= 0.0 && found->far_m > found->near_m && std::isfinite(found->far_m))) found.reset();
  }
  if (!found && options_.ground_up_m > -1e8) {
    const double depth = (options_.ground_up_m - view.T_world_camera.translation.z()) / direction.z();
    const double top =
        (options_.ground_up_m + options_.height_above_ground_m - view.T_world_camera.translation.z()) / direction.z();
    if (std::isfinite(depth) && depth > 0.0)
      found = sane(std::min(depth, top), depth + std::max(kLeastMargin, kFarMargin * depth));
  }
  if (!found) found = from_ties(box);
  if (!found) found = DepthRange{kDefaultNear, kDefaultFar};
  if (mode_of(options_) == Mode::paper) found->near_m = 0.0;
  return *found;
}

std::string DepthPrior::source() const {
  if (options_.max_depth_m > 0.0) return "options";
  if (bound_) return "bound";
  if (options_.ground_up_m > -1e8) return "ground";
  return any_ties_ ? "ties" : "default";
}

}  // namespace cairn::localisation
