// Targets among boxes that no target claims: points that several rays agree on.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "localisation/consensus.hpp"

namespace cairn::localisation {

// Frames (ascending) in which the whole candidate should be inside the image.
[[nodiscard]] std::vector<std::size_t> frames_showing(const PreparedBoxes& prepared, const Candidate& candidate,
                                                      const LocateOptions& options);

// Whether a box may belong to a point: reprojection, size and depth range.
class BoxJudge {
 public:
  BoxJudge(const PreparedBoxes& prepared, const DepthPrior& depth, const LocateOptions& options);

  [[nodiscard]] Sighting sighting(std::size_t box) const;
  // Triangulates the candidate's boxes, keeps the consistent ones (sorted) and sets fix and size. False where fewer
  // than two are left or the point leaves the depth range of most of them.
  [[nodiscard]] bool fit(Candidate& candidate) const;
  // The same from a start, without the search over pairs.
  [[nodiscard]] bool fit_from(const geometry::Vec3& start, Candidate& candidate) const;
  // Size [m] an object at `point` has if it fills the box.
  [[nodiscard]] double size(std::size_t box, const geometry::Vec3& point) const;
  [[nodiscard]] bool like_size(double a, double b) const;
  // Whether a box may be that of an object of `size_m` at `point`.
  [[nodiscard]] bool fits_size(std::size_t box, const geometry::Vec3& point, double size_m) const;
  [[nodiscard]] bool in_depth_range(std::size_t box, const geometry::Vec3& point) const;
  // The map extent of a box's ray over its depth range.
  [[nodiscard]] std::pair<geometry::Vec3, geometry::Vec3> ends(std::size_t box) const;

 private:
  [[nodiscard]] std::vector<Sighting> sightings(Candidate& candidate) const;
  [[nodiscard]] bool adopt(Candidate& candidate, const std::optional<Triangulation>& fix) const;

  const PreparedBoxes& prepared_;
  const LocateOptions& options_;
  std::vector<DepthRange> range_;  // per box
  bool bounded_ = false;           // whether the ranges come from evidence
};

// Greedy: of all pairs of pool boxes of one class, in different frames, of like size, whose rays meet in both depth
// ranges, the point with the greatest support (sum over frames of 1 - d^2/gate^2 of the best box); then again without
// the boxes it took. Ids are left unset. Cost: overlapping pairs x boxes near them.
[[nodiscard]] std::vector<Candidate> candidates_from_pool(const PreparedBoxes& prepared, const BoxJudge& judge,
                                                          const std::vector<std::size_t>& pool,
                                                          const LocateOptions& options);

}  // namespace cairn::localisation
