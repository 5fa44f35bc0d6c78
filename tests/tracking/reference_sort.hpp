// SORT written down from its equations: 7 x 7 matrices and an assignment by trying every one. Slow and plain, to
// compare with.
#pragma once

#include <Eigen/Core>
#include <Eigen/LU>
#include <algorithm>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "geometry/primitives.hpp"

namespace cairn::testing {

using Vec7 = Eigen::Matrix<double, 7, 1>;
using Mat7 = Eigen::Matrix<double, 7, 7>;
using Mat47 = Eigen::Matrix<double, 4, 7>;

class ReferenceFilter {
 public:
  explicit ReferenceFilter(const geometry::PixelBox& box) {
    x_.setZero();
    x_.head<4>() = measured(box);
    p_.setZero();
    p_.diagonal() << 10, 10, 10, 10, 1e4, 1e4, 1e4;
    h_.setZero();
    h_.leftCols<4>().setIdentity();
    r_.setZero();
    r_.diagonal() << 1, 1, 10, 10;
    q_.setZero();
    q_.diagonal() << 1, 1, 1, 1, .01, .01, .0001;
  }
  void predict(double dt = 1.0) {
    if (x_[2] + dt * x_[6] <= 0.0) x_[6] = 0.0;
    Mat7 f = Mat7::Identity();
    f(0, 4) = f(1, 5) = f(2, 6) = dt;
    x_ = f * x_;
    p_ = f * p_ * f.transpose() + dt * q_;
  }
  void update(const geometry::PixelBox& box) {
    const Eigen::Matrix4d s = h_ * p_ * h_.transpose() + r_;
    const Eigen::Matrix<double, 7, 4> k = p_ * h_.transpose() * s.inverse();
    x_ += k * (measured(box) - h_ * x_);
    const Mat7 a = Mat7::Identity() - k * h_;
    p_ = a * p_ * a.transpose() + k * r_ * k.transpose();
  }
  [[nodiscard]] geometry::PixelBox box() const {
    const double w = std::sqrt(x_[2] * x_[3]), h = x_[2] / w;
    return {x_[0] - w / 2, x_[1] - h / 2, x_[0] + w / 2, x_[1] + h / 2};
  }

 private:
  static Eigen::Vector4d measured(const geometry::PixelBox& b) {
    return {0.5 * (b.xmin + b.xmax), 0.5 * (b.ymin + b.ymax), b.area(), b.width() / b.height()};
  }
  Vec7 x_;
  Mat7 p_, q_;
  Mat47 h_;
  Eigen::Matrix4d r_;
};

inline double reference_iou(const geometry::PixelBox& a, const geometry::PixelBox& b) {
  const double w = std::min(a.xmax, b.xmax) - std::max(a.xmin, b.xmin);
  const double h = std::min(a.ymax, b.ymax) - std::max(a.ymin, b.ymin);
  if (w <= 0 || h <= 0) return 0.0;
  return w * h / (a.area() + b.area() - w * h);
}

// Track of each detection, -1 = none: every way to give detections to tracks is tried.
inline std::vector<int> reference_match(const std::vector<std::vector<double>>& iou, std::size_t tracks, double least) {
  const std::size_t n = iou.size();
  std::vector<int> best(n, -1);
  bool single = true, any = false;
  std::vector<int> rows(n, 0), columns(tracks, 0);
  for (std::size_t d = 0; d < n; ++d)
    for (std::size_t t = 0; t < tracks; ++t)
      if (iou[d][t] > least) {
        any = true;
        single = single && ++rows[d] == 1 && ++columns[t] == 1;
      }
  if (any && single) {
    for (std::size_t d = 0; d < n; ++d)
      for (std::size_t t = 0; t < tracks; ++t)
        if (iou[d][t] > least) best[d] = static_cast<int>(t);
    return best;
  }
  double best_sum = -1.0;
  std::vector<int> now(n, -1);
  std::vector<char> taken(tracks, 0);
  const std::function<void(std::size_t, double)> go = [&](std::size_t d, double sum) {
    if (d == n) {
      if (sum > best_sum) {
        best_sum = sum;
        best = now;
      }
      return;
    }
    for (std::size_t t = 0; t < tracks; ++t) {
      if (taken[t] != 0 || iou[d][t] <= 0.0) continue;
      taken[t] = 1;
      now[d] = static_cast<int>(t);
      go(d + 1, sum + iou[d][t]);
      taken[t] = 0;
    }
    now[d] = -1;
    go(d + 1, sum);
  };
  go(0, 0.0);
  for (std::size_t d = 0; d < n; ++d)
    if (best[d] >= 0 && iou[d][static_cast<std::size_t>(best[d])] < least) best[d] = -1;
  return best;
}

struct ReferenceRow {
  int frame = 0, id = 0;
  geometry::PixelBox box;
};

// All rows of a sequence, youngest track first within a frame.
inline std::vector<ReferenceRow> reference_sort(const std::vector<std::vector<geometry::PixelBox>>& frames,
                                                int min_hits, int max_age, double least) {
  struct Track {
    ReferenceFilter filter;
    int id, streak = 0, missed = 0;
  };
  std::vector<Track> tracks;
  std::vector<ReferenceRow> out;
  int next_id = 0, frame = 0;
  for (const auto& boxes : frames) {
    ++frame;
    for (auto& t : tracks) {
      t.filter.predict();
      if (t.missed > 0) t.streak = 0;
      ++t.missed;
    }
    std::erase_if(tracks, [](const Track& t) { return !std::isfinite(t.filter.box().xmin + t.filter.box().ymin); });
    std::vector<std::vector<double>> iou(boxes.size(), std::vector<double>(tracks.size()));
    for (std::size_t d = 0; d < boxes.size(); ++d)
      for (std::size_t t = 0; t < tracks.size(); ++t) iou[d][t] = reference_iou(boxes[d], tracks[t].filter.box());
    const auto match = reference_match(iou, tracks.size(), least);
    for (std::size_t d = 0; d < boxes.size(); ++d) {
      if (match[d] < 0) {
        tracks.push_back({ReferenceFilter(boxes[d]), ++next_id});
        continue;
      }
      auto& t = tracks[static_cast<std::size_t>(match[d])];
      t.filter.update(boxes[d]);
      t.missed = 0;
      ++t.streak;
    }
    for (std::size_t i = tracks.size(); i-- > 0;) {
      const auto& t = tracks[i];
      if (t.missed < 1 && (t.streak >= min_hits || frame <= min_hits)) out.push_back({frame, t.id, t.filter.box()});
    }
    std::erase_if(tracks, [&](const Track& t) { return t.missed > max_age; });
  }
  return out;
}

}  // namespace cairn::testing
