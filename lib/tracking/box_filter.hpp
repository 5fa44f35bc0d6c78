// The Kalman filter of one tracked box (SORT: Bewley et al. 2016, arXiv:1602.00763).
#pragma once

#include "geometry/primitives.hpp"

namespace cairn::tracking {

// State (u, v, s, r, du, dv, ds): centre [px], area [px^2], width/height, and their rates a step. Constant velocity,
// r constant, H = the first four. P0 = diag(10, 10, 10, 10, 1e4, 1e4, 1e4), Q = diag(1, 1, 1, 1, .01, .01, .0001) a
// step, R = diag(1, 1, 10, 10).
//
// F, H, Q, R and P0 couple u with du, v with dv, s with ds and nothing else, so the 7 x 7 filter is three filters of
// two states and one of one: the same numbers at a fraction of the cost. The covariance is updated in Joseph's form.
class BoxFilter {
 public:
  // box: finite, of positive width and height, px.
  explicit BoxFilter(const geometry::PixelBox& box);

  // dt > 0: time since the last prediction in steps of the nominal frame period; scales F and Q. 1 = plain SORT.
  // Where s + ds dt <= 0, ds is set to 0 first.
  void predict(double dt = 1.0);
  void update(const geometry::PixelBox& box);

  // Not finite where s r < 0 or s = 0: the caller drops the track.
  [[nodiscard]] geometry::PixelBox box() const;

 private:
  // One coordinate with its rate.
  struct Pair {
    double x = 0.0, rate = 0.0;
    double p_xx = 10.0, p_xr = 0.0, p_rr = 1e4;

    void predict(double dt, double q_x, double q_rate);
    void update(double measured, double r);
  };

  Pair u_, v_, s_;
  double r_ = 1.0, p_r_ = 10.0;
};

}  // namespace cairn::tracking
