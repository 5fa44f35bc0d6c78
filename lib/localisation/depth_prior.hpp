// How far away an object seen in a box may be.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>

#include "geometry/vec.hpp"
#include "localisation/boxes.hpp"
#include "localisation/options.hpp"
#include "localisation/points.hpp"

namespace cairn::localisation {

// The consumer's bound, e.g. from a terrain model: the depth range (along camera z, m) of an object
// whose box centre lies along `direction` (world, scaled so that depth 1 is `direction` long).
// Empty = no bound for this ray; the next source is asked.
using DepthBound = std::function<std::optional<DepthRange>(const View& view, const geometry::Vec3& direction)>;

// Sources in order: max-depth-m of the options; the consumer's bound; a level ground; the tie points that
// project near the box (a quarter of the image's diagonal), the middle 96 % of their depths, opened by
// 1 m or 5 % on the far side and by the greatest object height on the near side; 3 m to 18 m (the public
// code's range). `mode paper` keeps the far end and starts at 0.
class DepthPrior {
 public:
  DepthPrior(const survey::Survey& survey, const PreparedBoxes& prepared, const LocateOptions& options,
             DepthBound bound);

  [[nodiscard]] DepthRange range(const Box& box) const;
  // "options", "bound", "ground", "ties" or "default": where the ranges mostly come from.
  [[nodiscard]] std::string source() const;

 private:
  struct TieDepth {
    geometry::Vec2 pixel;
    double depth;
  };
  [[nodiscard]] std::optional<DepthRange> from_ties(const Box& box) const;

  const PreparedBoxes& prepared_;
  const LocateOptions& options_;
  DepthBound bound_;
  std::vector<std::vector<TieDepth>> ties_;  // per frame
  bool any_ties_ = false;
};

}  // namespace cairn::localisation
