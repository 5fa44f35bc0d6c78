#include "tracking/box_filter.hpp"

#include <cmath>

namespace cairn::tracking {
namespace {

constexpr double kQ = 1.0, kQRate = 0.01, kQAreaRate = 0.0001;  // a step
constexpr double kRCentre = 1.0, kRShape = 10.0;

struct Measurement {
  double u, v, s, r;
};

// The order of the operations is the reference's, so that a box comes back with the same rounding.
Measurement measurement(const geometry::PixelBox& box) {
  const double w = box.xmax - box.xmin, h = box.ymax - box.ymin;
  return {box.xmin + w / 2.0, box.ymin + h / 2.0, w * h, w / h};
}

}  // namespace

void BoxFilter::Pair::predict(double dt, double q_x, double q_rate) {
  x += dt * rate;
  const double row_xx = p_xx + dt * p_xr, row_xr = p_xr + dt * p_rr;
  p_xx = row_xx + dt * row_xr + q_x * dt;
  p_xr = row_xr;
  p_rr += q_rate * dt;
}

void BoxFilter::Pair::update(double measured, double r) {
  const double innovation = measured - x;
  const double inverse = 1.0 / (p_xx + r);
  const double gain_x = p_xx * inverse, gain_rate = p_xr * inverse;
  x += gain_x * innovation;
  rate += gain_rate * innovation;
  // (I - K H) P (I - K H)^T + K R K^T
  const double keep = 1.0 - gain_x;
  const double xx = keep * p_xx, xr = keep * p_xr;
  const double rx = p_xr - gain_rate * p_xx, rr = p_rr - gain_rate * p_xr;
  p_xx = xx * keep + gain_x * r * gain_x;
  p_xr = xr - xx * gain_rate + gain_x * r * gain_rate;
  p_rr = rr - rx * gain_rate + gain_rate * r * gain_rate;
}

BoxFilter::BoxFilter(const geometry::PixelBox& box) {
  const Measurement z = measurement(box);
  u_.x = z.u;
  v_.x = z.v;
  s_.x = z.s;
  r_ = z.r;
}

void BoxFilter::predict(double dt) {
  if (s_.rate * dt + s_.x <= 0.0) s_.rate = 0.0;
  u_.predict(dt, kQ, kQRate);
  v_.predict(dt, kQ, kQRate);
  s_.predict(dt, kQ, kQAreaRate);
  p_r_ += kQ * dt;
}

void BoxFilter::update(const geometry::PixelBox& box) {
  const Measurement z = measurement(box);
  u_.update(z.u, kRCentre);
  v_.update(z.v, kRCentre);
  s_.update(z.s, kRShape);
  const double gain = p_r_ / (p_r_ + kRShape), keep = 1.0 - gain;
  r_ += gain * (z.r - r_);
  p_r_ = keep * p_r_ * keep + gain * kRShape * gain;
}

geometry::PixelBox BoxFilter::box() const {
  const double w = std::sqrt(s_.x * r_);
  const double h = s_.x / w;
  return {u_.x - w / 2.0, v_.x - h / 2.0, u_.x + w / 2.0, v_.x + h / 2.0};
}

}  // namespace cairn::tracking
