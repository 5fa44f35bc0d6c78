#include "pipeline/vehicle_plot.hpp"

#include <algorithm>
#include <cmath>

#include "base/number_text.hpp"
#include "geometry/primitives.hpp"
#include "ground/pose_score.hpp"

namespace cairn::pipeline {
namespace {

using geometry::Vec2;
using survey::VehicleState;

constexpr double kWidth = 860.0, kLeft = 64.0, kRight = 20.0;
constexpr double kPlanTop = 56.0, kPlanHeight = 430.0, kTimeTop = 560.0, kTimeHeight = 150.0;
constexpr std::size_t kMostPoints = 2000;
constexpr const char* kLog = "#a9a196";
constexpr const char* kFilter = "#22577a";
constexpr const char* kTruth = "#2f2a24";
constexpr const char* kTaken = "#e09f3e";
constexpr const char* kRefused = "#a33b20";

std::string px(double value) {
  return base::to_fixed(value, 1);
}

std::string text(double x, double y, const char* anchor, const std::string& words, const std::string& more = "") {
  return "<text x=\"" + px(x) + "\" y=\"" + px(y) + "\" text-anchor=\"" + anchor + "\"" + more + ">" + words +
         "</text>\n";
}

std::string grid_line(double x1, double y1, double x2, double y2) {
  return "<line x1=\"" + px(x1) + "\" y1=\"" + px(y1) + "\" x2=\"" + px(x2) + "\" y2=\"" + px(y2) +
         "\" stroke=\"#e3e0da\"/>\n";
}

// A round number that cuts `span` into some five parts.
double step_of(double span) {
  const double raw = std::max(span, 1e-6) / 5.0, power = std::pow(10.0, std::floor(std::log10(raw)));
  for (const double factor : {1.0, 2.0, 5.0})
    if (raw <= factor * power) return factor * power;
  return 10.0 * power;
}

struct Panel {
  double left, top, width, height;      // px
  double x_low, x_high, y_low, y_high;  // values
  [[nodiscard]] Vec2 at(double x, double y) const {
    return {left + width * (x - x_low) / (x_high - x_low), top + height * (y_high - y) / (y_high - y_low)};
  }
};

std::string axes(const Panel& p, const std::string& x_unit, const std::string& title) {
  std::string svg = text(p.left, p.top - 8.0, "start", title, " font-weight=\"600\"");
  const double dx = step_of(p.x_high - p.x_low), dy = step_of(p.y_high - p.y_low);
  for (double x = std::ceil(p.x_low / dx) * dx; x <= p.x_high; x += dx) {
    const double at = p.at(x, p.y_low).x();
    svg += grid_line(at, p.top, at, p.top + p.height);
    svg += text(at, p.top + p.height + 16.0, "middle", base::to_text(std::round(x / dx) * dx));
  }
  for (double y = std::ceil(p.y_low / dy) * dy; y <= p.y_high; y += dy) {
    const double at = p.at(p.x_low, y).y();
    svg += grid_line(p.left, at, p.left + p.width, at);
    // Steps below 1 leave digits of rounding behind.
    svg += text(p.left - 8.0, at + 4.0, "end", base::to_fixed(std::round(y / dy) * dy, dy < 1.0 ? 2 : 0));
  }
  svg += text(p.left + p.width, p.top + p.height + 32.0, "end", x_unit);
  return svg;
}

std::string polyline(const std::vector<Vec2>& points, const char* colour, double width, const char* more = "") {
  std::string svg = "<polyline fill=\"none\" stroke=\"" + std::string(colour) + "\" stroke-width=\"" + px(width) +
                    "\" " + more + " points=\"";
  const std::size_t stride = std::max<std::size_t>(1, points.size() / kMostPoints);
  for (std::size_t i = 0; i < points.size(); i += stride)
    svg += (i > 0 ? " " : "") + px(points[i].x()) + "," + px(points[i].y());
  return svg + "\"/>\n";
}

std::string dot(const Vec2& at, const char* colour, double radius) {
  return "<circle cx=\"" + px(at.x()) + "\" cy=\"" + px(at.y()) + "\" r=\"" + px(radius) + "\" fill=\"" + colour +
         "\" fill-opacity=\"0.55\"/>\n";
}

template <typename Use>
void sparse(std::size_t count, const Use& use) {
  const std::size_t stride = std::max<std::size_t>(1, count / kMostPoints);
  for (std::size_t i = 0; i < count; i += stride) use(i);
}

Panel plan_panel(std::span<const VehicleState> filtered, std::span<const VehicleState> log) {
  geometry::Box3 box;
  for (const auto& s : filtered) box.extend({s.position.x(), s.position.y(), 0.0});
  // The log by itself may run far away: it is drawn where it stays near.
  const double margin = std::max(2.0, 0.1 * std::max(box.size().x(), box.size().y()));
  geometry::Box3 wide = box;
  wide.min.array() -= 3.0 * margin;
  wide.max.array() += 3.0 * margin;
  for (const auto& s : log) {
    const geometry::Vec3 p(s.position.x(), s.position.y(), 0.0);
    box.extend(p.cwiseMax(wide.min).cwiseMin(wide.max));
  }
  const double width = kWidth - kLeft - kRight;
  // One scale for both axes.
  const double metres_px =
      std::max((box.size().x() + 2.0 * margin) / width, (box.size().y() + 2.0 * margin) / kPlanHeight);
  const Vec2 c = box.centre().head<2>();
  return {kLeft,
          kPlanTop,
          width,
          kPlanHeight,
          c.x() - 0.5 * metres_px * width,
          c.x() + 0.5 * metres_px * width,
          c.y() - 0.5 * metres_px * kPlanHeight,
          c.y() + 0.5 * metres_px * kPlanHeight};
}

std::string plan(const Panel& p, std::span<const VehicleState> filtered, std::span<const VehicleState> log,
                 std::span<const VehicleState> truth, const std::vector<ground::PoseUpdate>& updates) {
  std::string svg = axes(p, "east [m]", "Tracks, north over east [m]");
  svg += "<g clip-path=\"url(#plan)\">\n";
  const auto drawn = [&](std::span<const VehicleState> track, const char* colour, double width, const char* more) {
    std::vector<Vec2> points;
    points.reserve(track.size());
    for (const auto& s : track) points.push_back(p.at(s.position.x(), s.position.y()));
    if (!points.empty()) svg += polyline(points, colour, width, more);
  };
  drawn(log, kLog, 1.4, "");
  sparse(updates.size(), [&](std::size_t i) {
    const auto& u = updates[i];
    svg += dot(p.at(u.position.x(), u.position.y()), u.accepted ? kTaken : kRefused, u.accepted ? 1.6 : 2.0);
  });
  drawn(truth, kTruth, 1.6, "stroke-dasharray=\"6 4\"");
  drawn(filtered, kFilter, 1.6, "");
  svg += "</g>\n";
  double x = kLeft;
  for (const auto& [colour, name] :
       {std::pair{kLog, "log by itself"}, std::pair{kFilter, "filter"}, std::pair{kTaken, "projected, taken"},
        std::pair{kRefused, "projected, refused"}, std::pair{kTruth, "truth"}}) {
    if (colour == kTruth && truth.empty()) continue;
    svg += "<rect x=\"" + px(x) + "\" y=\"20\" width=\"14\" height=\"6\" fill=\"" + colour + "\"/>\n";
    svg += text(x + 20.0, 27.0, "start", name);
    x += 150.0;
  }
  return svg;
}

std::string over_time(std::span<const VehicleState> filtered, std::span<const VehicleState> log,
                      std::span<const VehicleState> truth, const std::vector<ground::PoseUpdate>& updates) {
  const std::int64_t start = filtered.front().time_ns;
  const auto seconds = [&](std::int64_t ns) { return static_cast<double>(ns - start) * 1e-9; };
  std::vector<Vec2> filter_line, log_line, dots;
  const auto errors = [&](std::span<const VehicleState> track, std::vector<Vec2>& line) {
    sparse(track.size(), [&](std::size_t i) {
      if (const auto position = ground::position_at(truth, track[i].time_ns))
        line.emplace_back(seconds(track[i].time_ns), (track[i].position - *position).norm());
    });
  };
  if (!truth.empty()) {
    errors(filtered, filter_line);
    errors(log, log_line);
  } else {
    sparse(updates.size(), [&](std::size_t i) {
      if (updates[i].accepted) dots.emplace_back(seconds(updates[i].capture_time_ns), updates[i].residual.norm());
    });
  }
  double high = 0.5;
  for (const auto& p : filter_line) high = std::max(high, p.y());
  for (const auto& p : log_line) high = std::max(high, std::min(p.y(), 4.0));
  for (const auto& p : dots) high = std::max(high, p.y());
  const double last = std::max(1e-3, seconds(filtered.back().time_ns));
  const Panel p{kLeft, kTimeTop, kWidth - kLeft - kRight, kTimeHeight, 0.0, last, 0.0, 1.05 * high};
  std::string svg = axes(p, "time [s]", truth.empty() ? "Residuals of the positions taken [m]" : "Error [m]");
  svg += "<g clip-path=\"url(#time)\">\n";
  const auto placed = [&](std::vector<Vec2> line) {
    for (auto& q : line) q = p.at(q.x(), q.y());
    return line;
  };
  if (!log_line.empty()) svg += polyline(placed(log_line), kLog, 1.2);
  if (!filter_line.empty()) svg += polyline(placed(filter_line), kFilter, 1.4);
  for (const auto& q : placed(dots)) svg += dot(q, kTaken, 1.6);
  return svg + "</g>\n";
}

std::string clip(const char* id, double top, double height) {
  return "<clipPath id=\"" + std::string(id) + "\"><rect x=\"" + px(kLeft) + "\" y=\"" + px(top) + "\" width=\"" +
         px(kWidth - kLeft - kRight) + "\" height=\"" + px(height) + "\"/></clipPath>\n";
}

}  // namespace

std::string vehicle_plot(std::span<const VehicleState> filtered, std::span<const VehicleState> log,
                         std::span<const VehicleState> truth, const std::vector<ground::PoseUpdate>& updates) {
  const std::string size = "width=\"860\" height=\"760\" viewBox=\"0 0 860 760\"";
  std::string svg = "<svg xmlns=\"http://www.w3.org/2000/svg\" " + size +
                    " font-family=\"sans-serif\" font-size=\"11\" fill=\"#2f2a24\">\n"
                    "<rect width=\"860\" height=\"760\" fill=\"#ffffff\"/>\n<defs>" +
                    clip("plan", kPlanTop, kPlanHeight) + clip("time", kTimeTop, kTimeHeight) + "</defs>\n";
  if (!filtered.empty()) {
    svg += plan(plan_panel(filtered, log), filtered, log, truth, updates);
    svg += over_time(filtered, log, truth, updates);
  }
  return svg + "</svg>\n";
}

}  // namespace cairn::pipeline
