#include "tracking/frame_order.hpp"

#include <algorithm>
#include <map>
#include <string>

#include "base/error.hpp"
#include "base/number_text.hpp"

namespace cairn::tracking {
namespace {

constexpr double kLeastStep = 1e-3;  // nominal periods; of frames with one time stamp

using Indices = std::vector<std::size_t>;

class CameraOrder {
  [[nodiscard]] double time(std::size_t i) const { return static_cast<double>(frames_[i].time_ns); }
  [[nodiscard]] auto earlier() const {
    return [this](std::size_t a, std::size_t b) { return frames_[a].time_ns < frames_[b].time_ns; };
  }

 public:
  CameraOrder(std::span<const survey::Frame> frames, const FrameOrderOptions& options, FrameOrder& result)
      : frames_(frames), options_(options), result_(result) {}

  void append(Indices order) {
    const bool timed = std::any_of(order.begin(), order.end(), [&](std::size_t i) { return time(i) != 0.0; });
    if (!timed) {
      for (std::size_t k = 0; k < order.size(); ++k) result_.steps.push_back({order[k], 1.0, k == 0});
      return;
    }
    period_ = median_step(order);
    std::size_t begin = 0;
    for (const std::size_t end : stretches(order)) {
      const auto first = order.begin() + static_cast<std::ptrdiff_t>(begin),
                 last = order.begin() + static_cast<std::ptrdiff_t>(end);
      if (!std::is_sorted(first, last, earlier())) {
        notice(order[begin], "unsorted_frames", "time stamps do not ascend with the frame ids; taken in order of time");
        std::stable_sort(first, last, earlier());
      }
      take({first, last});
      begin = end;
    }
  }

 private:
  // Of two int64 without overflow; precise to the nanosecond for neighbours.
  [[nodiscard]] double step(std::size_t from, std::size_t to) const {
    const std::int64_t a = frames_[from].time_ns, b = frames_[to].time_ns;
    if ((a < 0) == (b < 0)) return static_cast<double>(b - a);
    return static_cast<double>(b) - static_cast<double>(a);
  }

  [[nodiscard]] double median_step(const Indices& order) const {
    std::vector<double> steps;
    for (std::size_t k = 1; k < order.size(); ++k)
      if (const double s = step(order[k - 1], order[k]); s > 0.0) steps.push_back(s);
    if (steps.empty()) return 1.0;
    const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
    std::nth_element(steps.begin(), middle, steps.end());
    return *middle;
  }

  // Ends of the stretches between backward jumps of the clock.
  [[nodiscard]] Indices stretches(const Indices& order) {
    Indices ends;
    for (std::size_t k = 1; k < order.size(); ++k)
      if (step(order[k - 1], order[k]) < -options_.clock_jump * period_) ends.push_back(k);
    if (ends.size() > std::max<std::size_t>(1, order.size() / 20)) ends.clear();
    for (const std::size_t k : ends)
      notice(order[k], "clock_jump",
             "the time stamp goes back by " + base::to_text(-step(order[k - 1], order[k]) / 1e9) +
                 " s: no track reaches across");
    ends.push_back(order.size());
    return ends;
  }

  void take(const Indices& order) {
    for (std::size_t k = 0; k < order.size(); ++k) {
      FrameStep next{order[k], 1.0, k == 0};
      if (k > 0) {
        const double s = step(order[k - 1], order[k]);
        if (s > options_.clock_jump * period_) {
          next.starts = true;
          notice(order[k], "clock_jump",
                 "the time stamp goes on by " + base::to_text(s / 1e9) + " s: no track reaches across");
        } else {
          if (s == 0.0) notice(order[k], "duplicate_time", "the frame before has the same time stamp");
          if (options_.real_time) next.dt = std::max(s / period_, kLeastStep);
        }
      }
      result_.steps.push_back(next);
    }
  }

  void notice(std::size_t frame, std::string reason, std::string message) {
    result_.notices.push_back(
        {"frame " + std::to_string(frames_[frame].id.value), std::move(reason), std::move(message)});
  }

  std::span<const survey::Frame> frames_;
  const FrameOrderOptions& options_;
  FrameOrder& result_;
  double period_ = 1.0;  // ns
};

}  // namespace

FrameOrder order_frames(std::span<const survey::Frame> frames, const FrameOrderOptions& options) {
  if (!(options.clock_jump > 1.0))
    throw base::Error(base::ErrorCode::invalid_argument, "clock jump is too short")
        .found(base::to_text(options.clock_jump))
        .allowed("more than 1 nominal period");
  std::map<survey::CameraId, Indices> by_camera;
  for (std::size_t i = 0; i < frames.size(); ++i) by_camera[frames[i].camera].push_back(i);
  FrameOrder result;
  CameraOrder order(frames, options, result);
  for (auto& [camera, indices] : by_camera) order.append(std::move(indices));
  return result;
}

}  // namespace cairn::tracking
