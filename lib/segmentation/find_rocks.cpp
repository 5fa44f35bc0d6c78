#include "segmentation/find_rocks.hpp"

#include <algorithm>
#include <utility>

#include "segmentation/patch_graph.hpp"
#include "segmentation/roughness.hpp"
#include "segmentation/touching.hpp"

namespace cairn::segmentation {
namespace {

using geometry::Vec3;

constexpr double kSkinSpacings = 5.0;     // reach of the surfaces fitted
constexpr double kShrubRoughness = 1.45;  // of an object's median residual over that of the ground around it
constexpr std::size_t kSkinPlaces = 300, kSkinPoints = 60;

// Whether what stands there has a skin as smooth as the ground about it, as rocks have and shrubs have not. Where there
// is too little of either to tell, it is given the benefit of the doubt.
bool has_skin(const Candidate& candidate, std::span<const Vec3> points, const GroundFilterResult& ground,
              const PlanIndex& index) {
  std::vector<Vec3> object, around;
  for (const auto i : candidate.points) object.push_back(points[i]);
  for (const auto i : index.within(candidate.centre, candidate.radius + 1.0))
    if (ground.classes[i] == PointClass::ground) around.push_back(points[i]);
  const double spacing = point_spacing(object);
  const auto typical = [&](const std::vector<Vec3>& of) {
    std::vector<Vec3> places;
    const std::size_t stride = std::max<std::size_t>(1, of.size() / kSkinPlaces);
    for (std::size_t i = 0; i < of.size(); i += stride) places.push_back(of[i]);
    return residual_quantile(skin_residuals(places, of, kSkinSpacings * spacing), 0.5);
  };
  if (object.size() < kSkinPoints || around.size() < kSkinPoints || !(spacing > 0.0)) return true;
  const double ordinary = typical(around);
  return ordinary <= 0.0 || typical(object) <= kShrubRoughness * ordinary;
}

}  // namespace

std::vector<Candidate> find_rocks(std::span<const Vec3> points, const GroundFilterResult& ground,
                                  const PlanIndex& index, const CandidateOptions& options) {
  std::vector<Candidate> rocks;
  for (const Candidate& object : find_candidates(points, ground, options))
    for (Candidate& part : part_touching(object, points, ground, {}))
      if (has_skin(part, points, ground, index)) rocks.push_back(std::move(part));
  return rocks;
}

}  // namespace cairn::segmentation
