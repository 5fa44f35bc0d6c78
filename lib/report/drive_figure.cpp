#include "report/drive_figure.hpp"

#include <algorithm>
#include <cmath>

#include "base/error.hpp"
#include "base/number_text.hpp"
#include "report/base64.hpp"
#include "report/charts.hpp"
#include "report/palette.hpp"
#include "report/png.hpp"
#include "report/svg_text.hpp"

namespace cairn::report {
namespace {

using geometry::Vec2;

constexpr double kMargin = 14.0, kTitle = 30.0, kLegendRow = 18.0, kScale = 34.0;

// Cost to colour; the ramp's pale end is the ground that costs nothing.
IndexedImage cost_image(const geometry::Grid<std::uint8_t>& cost) {
  IndexedImage image;
  image.width = cost.geometry.columns;
  image.height = cost.geometry.rows;
  for (int i = 0; i < 256; ++i) {
    if (i == 0) image.palette.push_back({255, 255, 255, 0});
    else if (i <= 252) image.palette.push_back(cost_ramp(0.75 * static_cast<double>(i) / 252.0));
    else if (i == 253) image.palette.push_back({88, 66, 104, 255});
    else if (i == 254) image.palette.push_back({24, 18, 30, 255});
    else image.palette.push_back({200, 200, 200, 255});
  }
  image.pixels = cost.values;
  return image;
}

class Frame {
 public:
  Frame(const Vec2& min, const Vec2& max, double width_px, double top)
      : min_(min), max_(max), top_(top), px_per_m_((width_px - 2.0 * kMargin) / (max.x() - min.x())) {}
  [[nodiscard]] Vec2 operator()(const Vec2& p) const {
    return {kMargin + px_per_m_ * (p.x() - min_.x()), top_ + px_per_m_ * (max_.y() - p.y())};
  }
  [[nodiscard]] double height() const { return px_per_m_ * (max_.y() - min_.y()); }
  [[nodiscard]] double px_per_m() const { return px_per_m_; }

 private:
  Vec2 min_, max_;
  double top_, px_per_m_;
};

std::string points_of(const std::vector<Vec2>& points, const Frame& frame) {
  std::string text;
  Vec2 last = Vec2::Constant(-1e9);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec2 p = frame(points[i]);
    // Shorter steps do not show.
    if (i + 1 < points.size() && (p - last).norm() < 1.5) continue;
    text += (text.empty() ? "" : " ") + svg::at(p);
    last = p;
  }
  return text;
}

std::string track(const DriveTrack& t, const Frame& frame) {
  if (t.points.size() < 2) return "";
  const std::string points = points_of(t.points, frame);
  const std::string dash = t.dashed ? "\" stroke-dasharray=\"7 4" : "";
  return "<polyline points=\"" + points + "\" fill=\"none\" stroke=\"#fff\" stroke-width=\"5\" stroke-opacity=\"0.8" +
         "\" stroke-linejoin=\"round\"/>\n<polyline points=\"" + points + "\" fill=\"none\" stroke=\"" + t.colour +
         "\" stroke-width=\"2.4\" stroke-linejoin=\"round" + dash + "\"/>\n";
}

std::string legend(const std::vector<DriveTrack>& tracks, double y) {
  std::string text;
  for (const DriveTrack& t : tracks) {
    if (t.label.empty()) continue;
    text +=
        svg::line({kMargin, y - 4.0}, {kMargin + 30.0, y - 4.0},
                  "stroke=\"" + t.colour + "\" stroke-width=\"2.4\"" + (t.dashed ? " stroke-dasharray=\"7 4\"" : ""));
    text += svg::text(kMargin + 38.0, y, "start", t.label);
    y += kLegendRow;
  }
  return text;
}

std::string background(const DriveBackground& picture, const Frame& frame) {
  if (picture.type.empty()) return "";
  const Vec2 corner = frame(Vec2(picture.min.x(), picture.max.y())),
             end = frame(Vec2(picture.max.x(), picture.min.y()));
  return "<image x=\"" + svg::px(corner.x()) + "\" y=\"" + svg::px(corner.y()) + "\" width=\"" +
         svg::px(end.x() - corner.x()) + "\" height=\"" + svg::px(end.y() - corner.y()) +
         "\" preserveAspectRatio=\"none\" href=\"data:image/" + picture.type + ";base64," + base64(picture.bytes) +
         "\"/>\n";
}

}  // namespace

std::string drive_figure_svg(const DriveFigure& figure) {
  const bool has_cost = !figure.cost.values.empty();
  const auto& g = figure.cost.geometry;
  const Vec2 min = has_cost ? Vec2(g.west, g.south()) : figure.min,
             max = has_cost ? Vec2(g.east(), g.north) : figure.max;
  if (!((max - min).minCoeff() > 0.0))
    throw base::Error(base::ErrorCode::invalid_argument, "a figure of a drive shows nothing");
  const Frame frame(min, max, figure.width_px, kTitle);
  const auto rows =
      std::count_if(figure.tracks.begin(), figure.tracks.end(), [](const auto& t) { return !t.label.empty(); });
  const double legend_y = kTitle + frame.height() + kScale + kLegendRow;
  std::string out = svg::open(figure.width_px, legend_y + kLegendRow * static_cast<double>(rows));
  out += svg::text(kMargin, 20.0, "start", figure.title, 15);
  const Vec2 corner = frame(Vec2(min.x(), max.y()));
  const std::string place = "x=\"" + svg::px(corner.x()) + "\" y=\"" + svg::px(corner.y()) + "\" width=\"" +
                            svg::px(figure.width_px - 2.0 * kMargin) + "\" height=\"" + svg::px(frame.height()) + "\"";
  out += background(figure.background, frame);
  if (has_cost)
    out += "<image " + place + " preserveAspectRatio=\"none\" image-rendering=\"pixelated\" opacity=\"" +
           base::to_fixed(figure.cost_opacity, 2) + "\" href=\"data:image/png;base64," +
           base64(encode_png(cost_image(figure.cost))) + "\"/>\n";
  for (const DriveOutline& o : figure.outlines)
    out += "<polygon points=\"" + points_of(o.ring, frame) + "\" fill=\"" + o.fill + "\" stroke=\"" + o.stroke +
           "\" stroke-width=\"1\"/>\n";
  for (const DriveTrack& t : figure.tracks) out += track(t, frame);
  for (const DriveMark& m : figure.marks) {
    const Vec2 p = frame(m.position);
    out += svg::dot(p, 5.0, "fill=\"#111\" stroke=\"#fff\" stroke-width=\"1.5\"");
    out += svg::text(p.x() + 8.0, p.y() - 8.0, "start", m.label, 13, "#111");
  }
  out += "<rect " + place + " fill=\"none\" stroke=\"#444\"/>\n";
  out += svg::scale_bar(kMargin, kTitle + frame.height() + 14.0, frame.px_per_m(), 160.0);
  out += legend(figure.tracks, legend_y);
  return out + "</svg>\n";
}

std::string update_periods_svg(const std::string& title, const std::vector<double>& times_s,
                               const std::vector<double>& periods_s, double set_s) {
  if (times_s.size() != periods_s.size() || times_s.empty())
    throw base::Error(base::ErrorCode::invalid_argument, "a figure of periods needs one time a period");
  constexpr double kWidth = 860.0, kHeight = 260.0, kLeft = 52.0, kTop = 40.0, kRight = 20.0, kBottom = 44.0;
  const double most = *std::max_element(periods_s.begin(), periods_s.end());
  double mean = 0.0;
  for (const double p : periods_s) mean += p;
  mean /= static_cast<double>(periods_s.size());
  const double first = times_s.front(), last = std::max(times_s.back(), first + 1.0),
               top = nice_ceiling(std::max(most, set_s));
  const auto x = [&](double t) { return kLeft + (kWidth - kLeft - kRight) * (t - first) / (last - first); };
  const auto y = [&](double p) { return kHeight - kBottom - (kHeight - kTop - kBottom) * p / top; };
  std::string out = svg::open(kWidth, kHeight);
  out += svg::text(kLeft, 22.0, "start",
                   title + ": mean " + base::to_fixed(mean, 2) + " s, greatest " + base::to_fixed(most, 2) + " s", 15);
  for (int i = 0; i <= 4; ++i) {
    const double p = top * i / 4.0;
    out += svg::line({kLeft, y(p)}, {kWidth - kRight, y(p)}, "stroke=\"#ddd\"");
    out += svg::text(kLeft - 6.0, y(p) + 4.0, "end", base::to_fixed(p, 2));
    const double t = first + (last - first) * i / 4.0;
    out += svg::text(x(t), kHeight - kBottom + 18.0, "middle", base::to_fixed(t, 0));
  }
  out += svg::text(0.5 * kWidth, kHeight - 8.0, "middle", "time, s");
  out += svg::text(kLeft - 40.0, kTop - 6.0, "start", "period, s");
  for (std::size_t i = 0; i < times_s.size(); ++i)
    out +=
        svg::line({x(times_s[i]), y(0.0)}, {x(times_s[i]), y(periods_s[i])}, "stroke=\"#0072b2\" stroke-width=\"2\"");
  out += svg::line({kLeft, y(mean)}, {kWidth - kRight, y(mean)}, "stroke=\"#d55e00\" stroke-width=\"1.5\"");
  out += svg::line({kLeft, y(set_s)}, {kWidth - kRight, y(set_s)}, "stroke=\"#222\" stroke-dasharray=\"4 3\"");
  out += svg::text(kWidth - kRight, y(set_s) - 4.0, "end", "set", 11);
  out += svg::text(kWidth - kRight, y(mean) - 4.0, "end", "mean", 11, "#d55e00");
  return out + "</svg>\n";
}

}  // namespace cairn::report
