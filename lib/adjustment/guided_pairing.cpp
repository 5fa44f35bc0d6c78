#include "adjustment/guided_pairing.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <optional>

#include "camera/projection.hpp"

namespace cairn::adjustment {
namespace {

using geometry::Vec2;
using geometry::Vec3;

// Features of an image by square cells.
class Cells {
 public:
  Cells(const GuidedView& view, double side) : side_(side) {
    columns_ = static_cast<std::size_t>(std::ceil(static_cast<double>(view.camera->width_px) / side)) + 1;
    rows_ = static_cast<std::size_t>(std::ceil(static_cast<double>(view.camera->height_px) / side)) + 1;
    std::vector<std::size_t> cell_of(view.features->size());
    first_.assign(columns_ * rows_ + 1, 0);
    for (std::size_t i = 0; i < cell_of.size(); ++i) {
      const auto& p = view.features->pixels[i];
      const auto column = std::min(columns_ - 1, static_cast<std::size_t>(std::max(0.0, p.x() / side)));
      const auto row = std::min(rows_ - 1, static_cast<std::size_t>(std::max(0.0, p.y() / side)));
      cell_of[i] = row * columns_ + column;
      ++first_[cell_of[i] + 1];
    }
    for (std::size_t c = 1; c < first_.size(); ++c) first_[c] += first_[c - 1];
    members_.resize(cell_of.size());
    auto next = first_;
    for (std::size_t i = 0; i < cell_of.size(); ++i) members_[next[cell_of[i]]++] = static_cast<std::uint32_t>(i);
  }

  // Adds the members of the cells that the square of half width `reach` about p touches.
  void near(const Vec2& p, double reach, std::vector<std::uint32_t>& found) const {
    const auto cell = [&](double x, std::size_t count) {
      return std::clamp(static_cast<std::ptrdiff_t>(std::floor(x / side_)), std::ptrdiff_t{0},
                        static_cast<std::ptrdiff_t>(count) - 1);
    };
    for (auto row = cell(p.y() - reach, rows_); row <= cell(p.y() + reach, rows_); ++row)
      for (auto column = cell(p.x() - reach, columns_); column <= cell(p.x() + reach, columns_); ++column) {
        const auto c = static_cast<std::size_t>(row) * columns_ + static_cast<std::size_t>(column);
        found.insert(found.end(), members_.begin() + static_cast<std::ptrdiff_t>(first_[c]),
                     members_.begin() + static_cast<std::ptrdiff_t>(first_[c + 1]));
      }
  }

 private:
  double side_;
  std::size_t columns_ = 0, rows_ = 0;
  std::vector<std::size_t> first_;
  std::vector<std::uint32_t> members_;
};

double distance_to_stretch(const Vec2& p, const Vec2& from, const Vec2& to) {
  const Vec2 along = to - from;
  const double length2 = along.squaredNorm();
  const double t = length2 > 0.0 ? std::clamp((p - from).dot(along) / length2, 0.0, 1.0) : 0.0;
  return (from + t * along - p).norm();
}

float product(const float* a, const float* b) {
  using Row = Eigen::Map<const Eigen::Matrix<float, static_cast<int>(kDescriptorBytes), 1>>;
  return Row(a).dot(Row(b));
}

}  // namespace

std::vector<FeaturePair> pair_features_guided(const GuidedView& a, const GuidedView& b, const GuidedOptions& options) {
  const auto units_a = unit_descriptors(*a.features, a.features->size());
  const auto units_b = unit_descriptors(*b.features, b.features->size());
  const double reach = options.tolerance * b.camera->fx_px;
  const Cells cells(b, std::max(4.0, reach));
  const auto width = static_cast<double>(b.camera->width_px), height = static_cast<double>(b.camera->height_px);

  std::vector<std::optional<FeaturePair>> of_b(b.features->size());
  std::vector<std::uint32_t> candidates;
  for (std::size_t i = 0; i < a.features->size(); ++i) {
    const Vec3 ray((*a.rays)[i].x(), (*a.rays)[i].y(), 1.0);
    const auto near = camera::project_world(*b.camera, b.T_world_camera, a.T_world_camera * (a.near_m * ray));
    const auto far = camera::project_world(*b.camera, b.T_world_camera, a.T_world_camera * (a.far_m * ray));
    if (!near || !far) continue;
    if (std::max(near->x(), far->x()) < -reach || std::min(near->x(), far->x()) > width + reach ||
        std::max(near->y(), far->y()) < -reach || std::min(near->y(), far->y()) > height + reach)
      continue;
    candidates.clear();
    const int steps = 1 + static_cast<int>(std::min(1000.0, (*far - *near).norm() / reach));
    for (int s = 0; s <= steps; ++s) {
      const Vec2 at = *near + (static_cast<double>(s) / steps) * (*far - *near);
      if (at.x() > -reach && at.y() > -reach && at.x() < width + reach && at.y() < height + reach)
        cells.near(at, reach, candidates);
    }
    std::sort(candidates.begin(), candidates.end());
    candidates.erase(std::unique(candidates.begin(), candidates.end()), candidates.end());
    float first = -2.0F, second = -2.0F;
    std::uint32_t best = 0;
    for (const auto j : candidates) {
      if (!(distance_to_stretch(b.features->pixels[j], *near, *far) <= reach)) continue;
      const float value = product(units_a.data() + i * kDescriptorBytes, units_b.data() + j * kDescriptorBytes);
      if (value > first) {
        second = first;
        first = value;
        best = j;
      } else if (value > second) {
        second = value;
      }
    }
    if (static_cast<double>(first) < options.least_closeness) continue;
    const double near2 = 2.0 - 2.0 * static_cast<double>(first), far2 = 2.0 - 2.0 * static_cast<double>(second);
    if (!(near2 < options.ratio * options.ratio * far2)) continue;
    auto& taken = of_b[best];
    if (!taken || first > taken->closeness) taken = FeaturePair{static_cast<std::uint32_t>(i), best, first};
  }
  std::vector<FeaturePair> result;
  for (const auto& pair : of_b)
    if (pair) result.push_back(*pair);
  std::sort(result.begin(), result.end(), [](const FeaturePair& x, const FeaturePair& y) { return x.a < y.a; });
  return result;
}

}  // namespace cairn::adjustment
