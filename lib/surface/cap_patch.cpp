#include "surface/cap_patch.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <map>

namespace cairn::surface {
namespace {

using geometry::Mat3;
using geometry::Vec2;
using geometry::Vec3;

double cross(const Vec2& a, const Vec2& b) {
  return a.x() * b.y() - a.y() * b.x();
}

Vec3 cross(const Vec3& a, const Vec3& b) {
  return {a.y() * b.z() - a.z() * b.y(), a.z() * b.x() - a.x() * b.z(), a.x() * b.y() - a.y() * b.x()};
}

// Points of a closed ring at even distances of about `step`.
std::vector<Vec3> resampled(std::span<const Vec3> ring, double step) {
  double length = 0.0;
  for (std::size_t i = 0; i < ring.size(); ++i) length += (ring[(i + 1) % ring.size()] - ring[i]).norm();
  const auto count = static_cast<std::size_t>(std::clamp(std::ceil(length / step), 8.0, 1500.0));
  std::vector<Vec3> result;
  double walked = 0.0;
  std::size_t next = 0;
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const Vec3 a = ring[i], b = ring[(i + 1) % ring.size()];
    const double side = (b - a).norm();
    while (next < count) {
      const double wanted = length * static_cast<double>(next) / static_cast<double>(count);
      if (wanted > walked + side || side == 0.0) break;
      result.push_back(a + (wanted - walked) / side * (b - a));
      ++next;
    }
    walked += side;
  }
  return result;
}

constexpr double kMarginSteps = 4.0;  // of the table beyond the outline

}  // namespace

CapPatch::CapPatch(std::span<const Vec3> outline, survey::CapModel model, const Vec3& up, double step) : step_(step) {
  const auto ring = resampled(outline, step);
  centre_.setZero();
  for (const auto& p : ring) centre_ += p / static_cast<double>(ring.size());
  Mat3 spread = Mat3::Zero();
  for (const auto& p : ring) spread += (p - centre_) * (p - centre_).transpose();
  const Eigen::SelfAdjointEigenSolver<Mat3> solver(spread);
  n_ = solver.eigenvectors().col(0);
  // A line along a narrow ridge may have its flattest side on edge: the rock stands on it, so it faces up.
  constexpr double kSteepest = 0.5;
  if (std::abs(n_.dot(up)) < kSteepest) n_ = up;
  if (n_.dot(up) < 0.0) n_ = -n_;
  const Vec3 aside = std::abs(n_.x()) < 0.9 ? Vec3(Vec3::UnitX()) : Vec3(Vec3::UnitY());
  u_ = (aside - aside.dot(n_) * n_).normalized();
  v_ = cross(n_, u_);
  double square = 0.0, twice = 0.0;
  for (const auto& p : ring) {
    ring_.push_back(flat(p));
    const double height = (p - centre_).dot(n_);
    heights_.push_back(model == survey::CapModel::plane ? 0.0 : height);
    square += height * height;
    box_.extend(p);
  }
  for (std::size_t i = 0; i < ring_.size(); ++i) twice += cross(ring_[i], ring_[(i + 1) % ring_.size()]);
  area_ = 0.5 * std::abs(twice);
  roughness_ = std::sqrt(square / static_cast<double>(ring.size()));
  if (twice < 0.0) {
    std::reverse(ring_.begin(), ring_.end());
    std::reverse(heights_.begin(), heights_.end());
  }
  tabulate(step);
}

Vec2 CapPatch::flat(const Vec3& p) const {
  return {(p - centre_).dot(u_), (p - centre_).dot(v_)};
}

double CapPatch::outline_distance(const Vec2& p, double& height) const {
  double best = 1e300;
  bool inside = false;
  for (std::size_t i = 0; i < ring_.size(); ++i) {
    const std::size_t j = (i + 1) % ring_.size();
    const Vec2 &a = ring_[i], &b = ring_[j];
    const Vec2 side = b - a;
    const double length2 = side.squaredNorm();
    const double t = length2 > 0.0 ? std::clamp((p - a).dot(side) / length2, 0.0, 1.0) : 0.0;
    const double d2 = (a + t * side - p).squaredNorm();
    if (d2 < best) {
      best = d2;
      height = heights_[i] + t * (heights_[j] - heights_[i]);
    }
    if ((a.y() > p.y()) != (b.y() > p.y()) && p.x() < a.x() + (p.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x()))
      inside = !inside;
  }
  return inside ? std::sqrt(best) : -std::sqrt(best);
}

double CapPatch::interpolated(const Vec2& p) const {
  // Mean value coordinates: weight of vertex i = (tan(a_{i-1}/2) + tan(a_i/2)) / |v_i - p|.
  const std::size_t count = ring_.size();
  std::vector<double> half_tangent(count), distance(count);
  for (std::size_t i = 0; i < count; ++i) {
    distance[i] = (ring_[i] - p).norm();
    if (distance[i] < 1e-9) return heights_[i];
  }
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t j = (i + 1) % count;
    const Vec2 a = ring_[i] - p, b = ring_[j] - p;
    const double across = cross(a, b), along = a.dot(b), radii = distance[i] * distance[j];
    if (std::abs(radii + along) < 1e-12 * radii)  // on the side itself
      return (heights_[i] * distance[j] + heights_[j] * distance[i]) / (distance[i] + distance[j]);
    half_tangent[i] = across / (radii + along);
  }
  double sum = 0.0, total = 0.0;
  for (std::size_t i = 0; i < count; ++i) {
    const double w = (half_tangent[(i + count - 1) % count] + half_tangent[i]) / distance[i];
    sum += w * heights_[i];
    total += w;
  }
  return total != 0.0 ? sum / total : 0.0;
}

void CapPatch::tabulate(double step) {
  Vec2 low = ring_.front(), high = ring_.front();
  for (const auto& p : ring_) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  const double margin = kMarginSteps * step;
  table_origin_ = low - Vec2(margin, margin);
  columns_ = static_cast<std::size_t>(std::ceil((high.x() - low.x() + 2 * margin) / step)) + 2;
  rows_ = static_cast<std::size_t>(std::ceil((high.y() - low.y() + 2 * margin) / step)) + 2;
  table_height_.resize(columns_ * rows_);
  table_depth_.resize(columns_ * rows_);
  const auto [least, most] = std::minmax_element(heights_.begin(), heights_.end());
  for (std::size_t r = 0; r < rows_; ++r)
    for (std::size_t c = 0; c < columns_; ++c) {
      const Vec2 p = table_origin_ + step * Vec2(static_cast<double>(c), static_cast<double>(r));
      double height = 0.0;
      const double depth = outline_distance(p, height);
      if (depth > 0.0) height = std::clamp(interpolated(p), *least, *most);
      table_height_[r * columns_ + c] = static_cast<float>(height);
      table_depth_[r * columns_ + c] = static_cast<float>(depth);
    }
}

double CapPatch::below(const Vec3& p, double& depth) const {
  const Vec2 q = flat(p);
  const double x = (q.x() - table_origin_.x()) / step_, y = (q.y() - table_origin_.y()) / step_;
  const double last_x = static_cast<double>(columns_) - 1.001, last_y = static_cast<double>(rows_) - 1.001;
  if (x < 0.0 || y < 0.0 || x > last_x || y > last_y) {
    depth = -kMarginSteps * step_;
    return -1e30;
  }
  const auto c = static_cast<std::size_t>(x), r = static_cast<std::size_t>(y);
  const double fx = x - static_cast<double>(c), fy = y - static_cast<double>(r);
  const auto mix = [&](const std::vector<float>& table) {
    const auto at = [&](std::size_t row, std::size_t column) {
      return static_cast<double>(table[row * columns_ + column]);
    };
    return (1 - fy) * ((1 - fx) * at(r, c) + fx * at(r, c + 1)) +
           fy * ((1 - fx) * at(r + 1, c) + fx * at(r + 1, c + 1));
  };
  depth = mix(table_depth_);
  return mix(table_height_) - (p - centre_).dot(n_) + std::min(0.0, depth);
}

std::vector<Vec3> CapPatch::samples() const {
  std::vector<Vec3> points;
  for (std::size_t r = 0; r < rows_; ++r)
    for (std::size_t c = 0; c < columns_; ++c) {
      const std::size_t i = r * columns_ + c;
      if (!(table_depth_[i] > 0.0F)) continue;
      const Vec2 q = table_origin_ + step_ * Vec2(static_cast<double>(c), static_cast<double>(r));
      points.push_back(centre_ + q.x() * u_ + q.y() * v_ + static_cast<double>(table_height_[i]) * n_);
    }
  return points;
}

std::vector<std::vector<Vec3>> pad_outlines(const survey::Contact& contact) {
  std::map<std::int64_t, std::map<std::int64_t, Vec3>> pads;
  for (const auto& vertex : contact) pads[vertex.pad][vertex.order] = vertex.position;
  std::vector<std::vector<Vec3>> outlines;
  for (const auto& [pad, line] : pads) {
    std::vector<Vec3> ring;
    for (const auto& [order, p] : line)
      if (ring.empty() || (p - ring.back()).norm() > 0.0) ring.push_back(p);
    if (ring.size() < 3) continue;
    Vec3 area = Vec3::Zero();
    double length = 0.0;
    for (std::size_t i = 0; i < ring.size(); ++i) {
      const Vec3 a = ring[i] - ring[0], b = ring[(i + 1) % ring.size()] - ring[0];
      area += 0.5 * cross(a, b);
      length += (b - a).norm();
    }
    // A sliver is a line there and back.
    constexpr double kLeastShare = 1e-3;
    if (area.norm() > kLeastShare * length * length) outlines.push_back(std::move(ring));
  }
  return outlines;
}

double cap_height_sigma(std::span<const CapPatch> caps, double spacing, double line_sigma) {
  double area = 0.0, square = 0.0;
  for (const auto& cap : caps) {
    area += cap.area();
    square += cap.area() * cap.roughness() * cap.roughness();
  }
  const double relief = area > 0.0 ? std::sqrt(square / area) : 0.0;
  return std::sqrt(relief * relief + spacing * spacing + line_sigma * line_sigma);
}

}  // namespace cairn::surface
