// The state of an adjustment between its rounds.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "adjustment/bundle.hpp"
#include "adjustment/bundle_system.hpp"
#include "adjustment/bundle_tracks.hpp"

namespace cairn::adjustment {

struct BundleWork {
  // Checks the problem; throws as adjust_bundle says. Observations that can never count go to `rejects`.
  BundleWork(const BundleProblem& problem, const BundleOptions& options, std::vector<base::Reject>& rejects);

  const BundleProblem& problem;
  const BundleOptions& options;
  std::vector<survey::Camera> cameras;
  std::vector<geometry::RigidTransform> poses;
  std::vector<std::int32_t> camera_of;
  std::vector<BundlePrior> priors;
  std::vector<Track> tracks;           // ties in order, then control points that are not check points
  std::vector<char> held, never_used;  // per frame
  std::vector<std::string> reason;     // per frame; "" = adjusted
  BundleGauge gauge = BundleGauge::aligned;
  double sigma_px = 1.0;
  std::vector<std::int32_t> system_index;                   // per frame into the last system; -1 = held
  std::vector<std::optional<geometry::Vec3>> start_points;  // per track

  [[nodiscard]] Views views() const { return {cameras, poses, camera_of}; }
  [[nodiscard]] std::size_t used_observations() const;
  [[nodiscard]] double median_error() const;  // of the used observations, px
  void remember_start();

  // The used part as indices; the losses are opened by `widening` >= 1.
  [[nodiscard]] BundleSystem system(double widening);
  void take(const BundleSystem& solved);
  // Moves poses and points.
  void apply(const geometry::Similarity& T);

 private:
  std::vector<std::int32_t> camera_index_, track_index_;
  std::vector<std::size_t> frames_in_, cameras_in_;
};

// Sum of distances, each cut at 100 px.
[[nodiscard]] double summed_error(const Views& views, const Track& track, const geometry::Vec3& p);
// Projected - observed [px].
[[nodiscard]] std::optional<geometry::Vec2> reprojection_residual(const Views& views, const TrackObservation& seen,
                                                                  const geometry::Vec3& p);

// What became of frames, control points and tie points.
void report_frames(const BundleWork& work, BundleResult& result);
void report_control(const BundleWork& work, BundleResult& result);
void report_points(const BundleWork& work, BundleResult& result);

}  // namespace cairn::adjustment
