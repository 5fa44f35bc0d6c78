#include "segmentation/plan_index.hpp"

#include <algorithm>
#include <cmath>

#include "geometry/primitives.hpp"

namespace cairn::segmentation {
namespace {

constexpr double kMaxCells = 4e6;

std::size_t clamped_cell(double offset, double cell, std::size_t count) {
  return static_cast<std::size_t>(std::clamp(std::floor(offset / cell), 0.0, static_cast<double>(count - 1)));
}

}  // namespace

PlanIndex::PlanIndex(std::span<const geometry::Vec3> points, double cell) : points_(points), cell_(cell) {
  geometry::Box3 box;
  for (const auto& p : points)
    if (p.allFinite()) box.extend(p);
  if (box.empty()) return;
  corner_ = box.min.head<2>();
  const geometry::Vec3 size = box.size();
  while ((std::floor(size.x() / cell_) + 1) * (std::floor(size.y() / cell_) + 1) > kMaxCells) cell_ *= 2;
  columns_ = static_cast<std::size_t>(size.x() / cell_) + 1;
  rows_ = static_cast<std::size_t>(size.y() / cell_) + 1;

  const auto cell_of = [this](const geometry::Vec3& p) {
    return clamped_cell(p.y() - corner_.y(), cell_, rows_) * columns_ +
           clamped_cell(p.x() - corner_.x(), cell_, columns_);
  };
  starts_.assign(columns_ * rows_ + 1, 0);
  for (const auto& p : points)
    if (p.allFinite()) ++starts_[cell_of(p) + 1];
  for (std::size_t i = 1; i < starts_.size(); ++i) starts_[i] += starts_[i - 1];
  entries_.resize(starts_.back());
  std::vector<std::uint32_t> next(starts_.begin(), starts_.end() - 1);
  for (std::size_t i = 0; i < points.size(); ++i)
    if (points[i].allFinite()) entries_[next[cell_of(points[i])]++] = static_cast<std::uint32_t>(i);
}

std::vector<std::size_t> PlanIndex::within(const geometry::Vec2& centre, double radius) const {
  std::vector<std::size_t> found;
  if (entries_.empty() || !(radius >= 0.0) || !centre.allFinite()) return found;
  const geometry::Vec2 low = centre - corner_ - geometry::Vec2::Constant(radius);
  const geometry::Vec2 high = centre - corner_ + geometry::Vec2::Constant(radius);
  if (high.x() < 0.0 || high.y() < 0.0) return found;
  const std::size_t first = clamped_cell(low.x(), cell_, columns_), last = clamped_cell(high.x(), cell_, columns_);
  for (std::size_t row = clamped_cell(low.y(), cell_, rows_); row <= clamped_cell(high.y(), cell_, rows_); ++row)
    for (std::size_t e = starts_[row * columns_ + first]; e < starts_[row * columns_ + last + 1]; ++e)
      if ((points_[entries_[e]].head<2>() - centre).squaredNorm() <= radius * radius) found.push_back(entries_[e]);
  std::sort(found.begin(), found.end());
  return found;
}

}  // namespace cairn::segmentation
