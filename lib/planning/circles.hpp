// Circles about a target: the estimation circle and the mapping circles of paper A.
#pragma once

#include <string>
#include <vector>

#include "base/options.hpp"
#include "base/reject.hpp"
#include "geometry/primitives.hpp"
#include "survey/camera.hpp"
#include "survey/mission.hpp"

namespace cairn::planning {

struct CircleOptions {
  // paper: equations of A24 to the letter, `points` images a circle, no overlap of circles.
  // robust: circles overlap, as many images as the views need; what is seen is proved by ray casting.
  std::string mode = "robust";
  double stand_off_m = 1.5;       // r_m: distance of the circle from the cylinder's wall
  double axis_deg = 60.0;         // gamma: camera axis below the horizon
  double scan_deg = 40.0;         // beta: vertical field of view that counts, symmetric about the axis
  std::int64_t points = 15;       // images a circle, least
  double vertical_overlap = 0.2;  // robust: of the scanned bands of successive circles, fraction of a band
  std::int64_t views = 2;         // robust: images each piece of wall and top is to be seen in ...
  double coverage = 0.99;         // ... over this share of the area of each

  void visit(base::OptionVisitor& v) {
    v.real("stand-off-m", stand_off_m, 0.2, 100.0, "distance of the mapping circles from the target's cylinder");
    v.real("axis-deg", axis_deg, 5.0, 85.0, "camera axis below the horizon on the mapping circles");
    v.real("scan-deg", scan_deg, 1.0, 120.0, "vertical field of view that counts, symmetric about the axis");
    v.integer("points", points, 3, 360, "images a circle, at least");
    v.real("vertical-overlap", vertical_overlap, 0.0, 0.9, "overlap of the bands scanned by successive circles");
    v.integer("views", views, 1, 20, "images each piece of the cylinder is to be seen in");
    v.real("cylinder-coverage", coverage, 0.0, 1.0, "share of wall and of top that must be seen so");
  }
};

// A24: z_1 = bottom + r_m tan(gamma + beta/2): the lower ray meets the foot of the wall; step = r_m (tan(gamma +
// beta/2) - tan(gamma - beta/2)), times (1 - overlap); the last circle is the first with z >= top + r_c tan(gamma -
// beta/2): the upper ray reaches the middle of the top. Ascending. Throws invalid_argument unless 0 < gamma - beta/2
// and gamma + beta/2 < 90 deg.
[[nodiscard]] std::vector<double> circle_heights(const geometry::VerticalCylinder& cylinder,
                                                 const CircleOptions& options, double overlap);

// What the images see of a cylinder, by ray casting against the cylinder itself; shares of area, 0..1.
struct CylinderCoverage {
  double side = 0.0, top = 0.0;                // in one image or more
  double side_wanted = 0.0, top_wanted = 0.0;  // in `views` or more
};
// A piece counts where it faces the camera, nothing of the cylinder is between, it lies inside the image, and within
// half the scan angle of the optical axis, measured vertically in the image. scan_deg <= 0: the whole image.
[[nodiscard]] CylinderCoverage cylinder_coverage(const geometry::VerticalCylinder& cylinder,
                                                 const std::vector<survey::Frame>& images, const survey::Camera& camera,
                                                 double scan_deg, std::int64_t views);

struct MappingCircles {
  std::vector<survey::Waypoint> waypoints;  // each an image; circles closed, azimuth never turns back
  std::vector<survey::Frame> images;        // one a waypoint, ids from 0
  std::size_t circles = 0, points_a_circle = 0;
  double radius_m = 0.0, overlap = 0.0;
  CylinderCoverage coverage;
};

// Circles of radius r_e + r_m from the lowest up, all turned through the same way, from the azimuth `start_deg` (as
// seen from the axis, clockwise from north); the first point of each circle is passed again at its end, and the next
// begins above it. Headings go on growing: the yaw never unwinds (D31). robust: points and overlap grow until coverage
// >= options.coverage in options.views images (120 points and 0.8 at most). Throws invalid_argument for a cylinder
// without height or radius, one that is not finite, a camera whose vertical field of view is smaller than scan_deg, or
// angles that circle_heights refuses.
[[nodiscard]] MappingCircles mapping_circles(const geometry::VerticalCylinder& cylinder, const survey::Camera& camera,
                                             const CircleOptions& options, double start_deg);

// Why no circles can be flown about a cylinder: "cylinder_not_finite", "cylinder_without_height",
// "cylinder_without_radius"; "" where they can.
[[nodiscard]] std::string unfit(const geometry::VerticalCylinder& cylinder);

// A22: the circle at the search height z_s about the vertical through a target's centre, from which the line to the
// centre falls at gamma_0 [deg below the horizon]: radius (z_s - z_e) / tan(gamma_0). Begins at the point closest to
// `from` (north of the centre where the vehicle hovers above it: no direction is closer) and makes one turn, clockwise.
// points >= 3; the first is passed again at the end. Throws invalid_argument where z_s is not above the centre.
[[nodiscard]] std::vector<survey::Waypoint> estimation_circle(const geometry::Vec3& centre, double search_up,
                                                              const geometry::Vec3& from, double angle_deg,
                                                              std::size_t points);

}  // namespace cairn::planning
