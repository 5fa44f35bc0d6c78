#include "localisation/association.hpp"

#include <algorithm>

#include "geometry/assignment.hpp"

namespace cairn::localisation {

using geometry::Mat3;
using geometry::Vec3;

std::vector<std::size_t> count_inside(const Points& points, const View& view, std::span<const geometry::PixelBox> boxes,
                                      bool cheirality) {
  std::vector<std::size_t> counts(boxes.size(), 0);
  if (boxes.empty() || points.rows() == 0) return counts;
  const Mat3& R = view.T_world_camera.rotation;
  const Vec3& t = view.T_world_camera.translation;
  const Eigen::ArrayXd x = points.col(0).array() - t.x(), y = points.col(1).array() - t.y(),
                       z = points.col(2).array() - t.z();
  const Eigen::ArrayXd depth = R(0, 2) * x + R(1, 2) * y + R(2, 2) * z;
  const Eigen::ArrayXd u = (R(0, 0) * x + R(1, 0) * y + R(2, 0) * z) / depth * view.fx_px + view.cx_px;
  const Eigen::ArrayXd v = (R(0, 1) * x + R(1, 1) * y + R(2, 1) * z) / depth * view.fy_px + view.cy_px;
  const double umin = u.minCoeff(), umax = u.maxCoeff(), vmin = v.minCoeff(), vmax = v.maxCoeff();
  for (std::size_t b = 0; b < boxes.size(); ++b) {
    const auto& box = boxes[b];
    if (box.xmin > umax || box.xmax < umin || box.ymin > vmax || box.ymax < vmin) continue;
    const auto in = u >= box.xmin && u <= box.xmax && v >= box.ymin && v <= box.ymax;
    counts[b] = static_cast<std::size_t>(cheirality ? (in && depth > 0.0).count() : in.count());
  }
  return counts;
}

std::vector<std::size_t> associate(const std::vector<double>& score, std::size_t targets, std::size_t boxes,
                                   double least) {
  std::vector<double> cost(score.size());
  std::transform(score.begin(), score.end(), cost.begin(), [](double s) { return -s; });
  auto pairs = geometry::assign(cost, targets, boxes);
  for (std::size_t t = 0; t < pairs.size(); ++t)
    if (pairs[t] != geometry::kUnassigned &&
        !(score[t * boxes + pairs[t]] >= least && score[t * boxes + pairs[t]] > 0.0))
      pairs[t] = geometry::kUnassigned;
  return pairs;
}

}  // namespace cairn::localisation
