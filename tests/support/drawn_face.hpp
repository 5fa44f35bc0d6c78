// A face drawn with ellipses: face detectors take it for one. Its outline is known.
#pragma once

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "geometry/colour_image.hpp"
#include "geometry/primitives.hpp"

namespace cairn::testing {

inline cv::Mat grey_background(int width, int height) {
  return cv::Mat(height, width, CV_8UC3, cv::Scalar(120, 140, 130));
}

// Draws a face with its outline `height` px high about (x, y), blue-green-red; gives the outline's box.
inline geometry::PixelBox draw_face(cv::Mat& image, int x, int y, int height) {
  const double k = height / 190.0;
  const auto len = [k](double v) { return static_cast<int>(v * k); };
  const auto thick = [&](double v) { return len(v) + 1; };
  const auto at = [&](double dx, double dy) { return cv::Point(x + len(dx), y + len(dy)); };
  const auto size = [&](double w, double h) { return cv::Size(len(w), len(h)); };
  const int smooth = cv::LINE_AA;
  cv::ellipse(image, at(0, -12), size(82, 105), 0, 0, 360, cv::Scalar(25, 30, 45), -1, smooth);
  cv::ellipse(image, at(0, 0), size(70, 95), 0, 0, 360, cv::Scalar(140, 170, 215), -1, smooth);
  for (const int side : {-28, 28}) {
    cv::ellipse(image, at(side, -32), size(17, 4), 0, 180, 360, cv::Scalar(40, 50, 70), thick(3), smooth);
    cv::ellipse(image, at(side, -18), size(14, 7), 0, 0, 360, cv::Scalar(235, 235, 240), -1, smooth);
    cv::circle(image, at(side, -18), len(6), cv::Scalar(50, 60, 80), -1, smooth);
    cv::circle(image, at(side, -18), len(3), cv::Scalar(10, 10, 10), -1, smooth);
  }
  cv::line(image, at(0, -10), at(-8, 22), cv::Scalar(110, 140, 185), thick(3), smooth);
  cv::ellipse(image, at(0, 24), size(13, 5), 0, 0, 180, cv::Scalar(90, 120, 165), thick(3), smooth);
  cv::ellipse(image, at(0, 50), size(26, 9), 0, 0, 360, cv::Scalar(90, 90, 180), -1, smooth);
  cv::line(image, at(-26, 50), at(26, 50), cv::Scalar(50, 50, 110), thick(2), smooth);
  return {x - 70 * k, y - 95 * k, x + 70 * k, y + 95 * k};
}

inline geometry::ColourImage colour_image(const cv::Mat& bgr) {
  cv::Mat rgb;
  cv::cvtColor(bgr, rgb, cv::COLOR_BGR2RGB);
  return {
      static_cast<std::size_t>(rgb.cols), static_cast<std::size_t>(rgb.rows), {rgb.data, rgb.data + 3 * rgb.total()}};
}

}  // namespace cairn::testing
