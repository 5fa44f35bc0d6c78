// The hidden base of a rock, closed from its contact line.
#pragma once

#include <span>
#include <vector>

#include "geometry/primitives.hpp"
#include "geometry/vec.hpp"
#include "survey/contact.hpp"
#include "survey/rock.hpp"

namespace cairn::surface {

// One surface under one pad: over the best-fit plane of its outline, a height that is the outline's own on the line
// and the mean value interpolant of it inside (Floater 2003, CAGD 20:19), or 0 for the plane model.
// Outside the outline it droops at 45 degrees, so that what hangs over the line is not cut.
class CapPatch {
 public:
  // outline: closed ring in space [m], at least 3 points not on a line, in order (either sense); up: side on which the
  // rock stands; step [m]: resolution inside.
  CapPatch(std::span<const geometry::Vec3> outline, survey::CapModel model, const geometry::Vec3& up, double step);

  // Signed height below the surface [m]: > 0 outside the rock. `depth`: distance from the outline within the plane,
  // > 0 inside it.
  [[nodiscard]] double below(const geometry::Vec3& p, double& depth) const;
  [[nodiscard]] const geometry::Vec3& normal() const { return n_; }  // unit, into the rock
  // Points on the cap, about `step` apart.
  [[nodiscard]] std::vector<geometry::Vec3> samples() const;
  [[nodiscard]] double area() const { return area_; }            // of the outline in its plane, m^2
  [[nodiscard]] double roughness() const { return roughness_; }  // rms of the outline about its plane, m
  [[nodiscard]] geometry::Box3 bounds() const { return box_; }

 private:
  [[nodiscard]] geometry::Vec2 flat(const geometry::Vec3& p) const;
  [[nodiscard]] double outline_distance(const geometry::Vec2& p, double& height) const;
  [[nodiscard]] double interpolated(const geometry::Vec2& p) const;
  void tabulate(double step);

  geometry::Vec3 centre_, u_, v_, n_;
  std::vector<geometry::Vec2> ring_;  // counter-clockwise about n
  std::vector<double> heights_;
  double area_ = 0.0, roughness_ = 0.0, step_ = 0.0;
  geometry::Box3 box_;
  // Height and depth on a grid of the plane: x fastest.
  geometry::Vec2 table_origin_ = geometry::Vec2::Zero();
  std::size_t columns_ = 0, rows_ = 0;
  std::vector<float> table_height_, table_depth_;
};

// Outlines of the pads of a contact, in order of pad; pads of fewer than 3 points, or of no area, are left out.
[[nodiscard]] std::vector<std::vector<geometry::Vec3>> pad_outlines(const survey::Contact& contact);

// Standard deviation of the cap's height about the truth [m]: the line tells what relief the contact has along its rim
// and takes the same for the inside, at least the spacing of the points and what the line's own sigma says.
[[nodiscard]] double cap_height_sigma(std::span<const CapPatch> caps, double spacing, double line_sigma);

}  // namespace cairn::surface
