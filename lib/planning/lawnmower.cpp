#include "planning/lawnmower.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "base/angle.hpp"
#include "base/error.hpp"
#include "base/number_text.hpp"
#include "camera/projection.hpp"
#include "planning/camera_aim.hpp"

namespace cairn::planning {
namespace {

using geometry::Vec2;
using geometry::Vec3;
using survey::Waypoint;

constexpr double kFlattestRay_deg = 75.0;  // from the vertical: beyond, a footprint has no useful end
constexpr double kShrink = 0.95;
constexpr int kMostShrinks = 20;
constexpr double kSamePath_m = 0.3;  // a lane that follows the terrain keeps its heights within this

// On a level plane 1 m below the camera: distances ahead of it, and width.
struct Footprint {
  double near = 0.0, far = 0.0, width = 0.0;
};

Footprint unit_footprint(const survey::Camera& camera, double pitch_deg) {
  const auto pose = camera_pose(Vec3::Zero(), 0.0, pitch_deg);
  const auto w = static_cast<double>(camera.width_px), h = static_cast<double>(camera.height_px);
  const double flattest = std::tan(base::deg_to_rad(kFlattestRay_deg));
  Footprint f{-std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity(), 0.0};
  double left = -std::numeric_limits<double>::infinity(), right = -left;
  constexpr int kSamples = 16;
  for (int i = 0; i <= kSamples; ++i) {
    const double t = static_cast<double>(i) / kSamples;
    const auto on_plane = [&](double u, double v) {
      const auto ray = camera::pixel_ray(camera, pose, {u, v});
      if (!ray)
        throw base::Error(base::ErrorCode::invalid_argument, "the camera's edge cannot be unprojected")
            .record("camera " + std::to_string(camera.id.value));
      const Vec3 d = ray->direction;
      // A ray too flat, or above the horizon, ends at the flattest that counts.
      if (-d.z() * flattest < d.head<2>().norm()) return Vec2(d.head<2>().normalized() * flattest);
      return Vec2(d.head<2>() / -d.z());
    };
    f.near = std::max(f.near, on_plane(t * w, h).y());
    f.far = std::min(f.far, on_plane(t * w, 0.0).y());
    left = std::max(left, on_plane(0.0, t * h).x());
    right = std::min(right, on_plane(w, t * h).x());
  }
  f.width = right - left;
  if (!(f.far > f.near) || !(f.width > 0.0))
    throw base::Error(base::ErrorCode::invalid_argument, "the camera does not see the ground with this pitch")
        .found(base::to_text(pitch_deg) + " deg")
        .allowed("down to -90 deg");
  return f;
}

// Evenly spaced positions over [low, high], at most `spacing` apart, the outer ones `edge` inside (negative: outside).
std::vector<double> evenly(double low, double high, double spacing, double edge) {
  const double length = high - low - 2.0 * edge;
  if (length <= 0.0) return {0.5 * (low + high)};
  const auto n = static_cast<std::size_t>(std::ceil(length / spacing - 1e-9)) + 1;
  std::vector<double> at(n);
  for (std::size_t i = 0; i < n; ++i)
    at[i] = low + edge + length * static_cast<double>(i) / static_cast<double>(std::max<std::size_t>(n - 1, 1));
  return at;
}

struct Design {
  double reach_near, reach_far;  // of the footprint ahead of the camera, m
  double across;                 // width of the footprint, m
  double base, spacing;          // largest distance of images and of lanes, m
};

// Footprint centres of one stretch of lane, in order of flight.
struct Run {
  std::vector<Vec2> cameras;
  double heading_deg = 0.0;
  std::int64_t lane = 0;
};

std::vector<Run> lay_lanes(const Area& area, double azimuth, const Design& d, const LawnmowerOptions& options,
                           std::int64_t first_lane) {
  const bool full = options.border == "full";
  const double along_length = d.reach_far - d.reach_near;
  const auto edge = [full](double spacing, double size) {
    return full ? std::min(0.5 * spacing, spacing - 0.5 * size) : 0.5 * spacing;
  };
  const auto [low, high] = across_range(area, azimuth);
  const Vec2 forward(std::sin(azimuth), std::cos(azimuth)), sideways(std::cos(azimuth), -std::sin(azimuth));
  const double ahead = 0.5 * (d.reach_near + d.reach_far);
  std::vector<Run> runs;
  std::int64_t lane = first_lane;
  bool reverse = false;
  for (const double across : evenly(low, high, d.spacing, edge(d.spacing, d.across))) {
    const double half = full ? 0.5 * d.across : std::min(0.5 * d.across, 0.5 * d.spacing + 1e-6);
    auto extents = strip_extents(area, azimuth, std::max(low, across - half), std::min(high, across + half));
    // Flying on over a short gap is less than a turn.
    for (std::size_t i = 0; i + 1 < extents.size();) {
      if (extents[i + 1].first - extents[i].second > along_length) {
        ++i;
        continue;
      }
      extents[i].second = extents[i + 1].second;
      extents.erase(extents.begin() + static_cast<std::ptrdiff_t>(i) + 1);
    }
    if (extents.empty()) continue;
    if (reverse) std::reverse(extents.begin(), extents.end());
    const double direction = reverse ? -1.0 : 1.0;
    const bool turned = reverse && options.heading == "lane";
    for (const auto& [from, to] : extents) {
      auto centres = evenly(from, to, d.base, edge(d.base, along_length));
      if (reverse) std::reverse(centres.begin(), centres.end());
      Run run;
      run.lane = lane;
      run.heading_deg = base::rad_to_deg(azimuth) + (turned ? 180.0 : 0.0);
      const double back = options.heading == "lane" ? direction * ahead : ahead;
      for (const double along : centres) run.cameras.emplace_back((along - back) * forward + across * sideways);
      runs.push_back(std::move(run));
    }
    ++lane;
    reverse = !reverse;
  }
  return runs;
}

// Keeps every height or more, climbs no steeper than `slope`.
void limit_climb(std::vector<Vec3>& path, double slope) {
  const auto lift = [slope](const Vec3& from, Vec3& to) {
    to.z() = std::max(to.z(), from.z() - slope * (to - from).head<2>().norm());
  };
  for (std::size_t i = 1; i < path.size(); ++i) lift(path[i - 1], path[i]);
  for (std::size_t i = path.size(); i-- > 1;) lift(path[i], path[i - 1]);
}

// Indices of the points needed so that straight lines between them pass all others within `tolerance` in height
// (Douglas and Peucker).
void keep_corners(const std::vector<Vec3>& path, std::size_t first, std::size_t last, double tolerance,
                  std::vector<std::size_t>& kept) {
  double worst = tolerance;
  std::size_t at = 0;
  const double length = (path[last] - path[first]).head<2>().norm();
  for (std::size_t i = first + 1; i < last; ++i) {
    const double t = length > 0.0 ? (path[i] - path[first]).head<2>().norm() / length : 0.0;
    const double off = std::abs(path[i].z() - (path[first].z() + t * (path[last].z() - path[first].z())));
    if (off > worst) {
      worst = off;
      at = i;
    }
  }
  if (at == 0) return;
  keep_corners(path, first, at, tolerance, kept);
  kept.push_back(at);
  keep_corners(path, at, last, tolerance, kept);
}

class Planner {
 public:
  Planner(const Area& area, const survey::Camera& camera, const SurfaceHeights& surface,
          const LawnmowerOptions& options)
      : area_(area), camera_(camera), surface_(surface), options_(options) {
    footprint_ = unit_footprint(camera, options.pitch_deg);
    const double depression = std::sin(base::deg_to_rad(-options.pitch_deg));
    plan_.height_m =
        options.gsd_m > 0.0 ? options.gsd_m * std::sqrt(camera.fx_px * camera.fy_px) * depression : options.height_m;
    azimuth_ = options.azimuth_deg >= 0.0 ? base::deg_to_rad(options.azimuth_deg) : narrowest_azimuth(area);
    read_surface();
  }

  LawnmowerPlan run(base::RunContext& ctx) {
    const auto views_of = [](double overlap) {
      return static_cast<std::size_t>(std::floor(1.0 / (1.0 - overlap) + 1e-6));
    };
    plan_.wanted_views =
        options_.border == "full"
            ? views_of(options_.front_overlap) * views_of(options_.side_overlap) * (options_.cross_hatch ? 2 : 1)
            : 1;
    double shrink = 1.0;
    for (int i = 0;; ++i, shrink *= kShrink) {
      ctx.check_stop();
      lay(shrink);
      plan_.overlap = count_overlap(area_, plan_.views, camera_, surface_,
                                    0.2 * std::min(plan_.image_spacing_m, plan_.lane_spacing_m));
      if (plan_.overlap.uncovered == 0 && plan_.overlap.first_percentile >= plan_.wanted_views) break;
      if (i == kMostShrinks) {
        plan_.notes.push_back("on this surface " + std::to_string(plan_.overlap.uncovered) + " of " +
                              std::to_string(plan_.overlap.points) + " sample points are in no image, 1 % in " +
                              std::to_string(plan_.overlap.first_percentile) + " or fewer; fly higher");
        break;
      }
    }
    if (shrink < 1.0)
      plan_.notes.push_back("lanes and images are " + base::to_fixed(100.0 * (1.0 - shrink), 0) +
                            " % closer than on level ground, to keep the overlap on the surface's high parts");
    return std::move(plan_);
  }

 private:
  void read_surface() {
    if (surface_.is_plane()) {
      low_ = high_ = top_ = surface_.lowest();
      return;
    }
    geometry::Box3 box;
    for (const auto& ring : area_)
      for (const Vec2& p : ring) box.extend({p.x(), p.y(), 0.0});
    // About 200 000 samples whatever the size.
    const double step = std::max(surface_.cell(), std::sqrt(box.size().x() * box.size().y() / 2e5));
    std::vector<double> heights;
    for (double n = box.min.y() + 0.5 * step; n < box.max.y(); n += step)
      for (double e = box.min.x() + 0.5 * step; e < box.max.x(); e += step)
        if (inside(area_, {e, n}))
          if (const auto up = surface_.up({e, n})) heights.push_back(*up);
    if (heights.empty())
      throw base::Error(base::ErrorCode::invalid_input, "the surface is not known anywhere in the area")
          .allowed("a terrain that overlaps the area")
          .hint("Check that area and terrain are of the same place");
    std::sort(heights.begin(), heights.end());
    const auto at = [&heights](double f) {
      return heights[static_cast<std::size_t>(f * static_cast<double>(heights.size() - 1))];
    };
    low_ = at(0.02);
    high_ = at(0.98);
    top_ = heights.back();
  }

  // Height of the surface that the spacing is made for, below the camera.
  [[nodiscard]] double range() const {
    return options_.follow_terrain ? plan_.height_m : std::max(0.2 * plan_.height_m, level() - high_);
  }
  [[nodiscard]] double level() const { return std::max(low_ + plan_.height_m, top_ + options_.clearance_m); }

  void lay(double shrink) {
    plan_.waypoints.clear();
    plan_.views.clear();
    plan_.view_waypoint.clear();
    if (!options_.follow_terrain && level() > low_ + plan_.height_m && shrink == 1.0)
      plan_.notes.push_back("flown " + base::to_fixed(level() - low_, 1) + " m above the low ground, not " +
                            base::to_fixed(plan_.height_m, 1) + " m: " + base::to_text(options_.clearance_m) +
                            " m above the highest point");
    const double h = range();
    Design d{footprint_.near * h, footprint_.far * h, footprint_.width * h, 0.0, 0.0};
    plan_.footprint_along_m = d.reach_far - d.reach_near;
    plan_.footprint_across_m = d.across;
    d.base = plan_.image_spacing_m = shrink * (1.0 - options_.front_overlap) * plan_.footprint_along_m;
    d.spacing = plan_.lane_spacing_m = shrink * (1.0 - options_.side_overlap) * d.across;
    auto runs = lay_lanes(area_, azimuth_, d, options_, 0);
    plan_.lanes = runs.empty() ? 0 : static_cast<std::size_t>(runs.back().lane + 1);
    if (options_.cross_hatch) {
      auto across = lay_lanes(area_, azimuth_ + base::deg_to_rad(90.0), d, options_, runs.back().lane + 1);
      runs.insert(runs.end(), across.begin(), across.end());
      plan_.lanes = static_cast<std::size_t>(runs.back().lane + 1);
    }
    for (const Run& run : runs) add(run, d);
  }

  [[nodiscard]] double flying_height(const Vec2& p, double heading_deg, const Design& d) const {
    if (!options_.follow_terrain) return level();
    const double heading = base::deg_to_rad(heading_deg);
    const Vec2 looked_at = p + 0.5 * (d.reach_near + d.reach_far) * Vec2(std::sin(heading), std::cos(heading));
    const double below = surface_.quantile(looked_at, 0.25 * d.across, 0.5).value_or(high_);
    const double near = surface_.highest(p, options_.clearance_radius_m).value_or(top_);
    return std::max(below + plan_.height_m, near + options_.clearance_m);
  }

  void add(const Run& run, const Design& d) {
    std::vector<Vec3> path;
    for (const Vec2& p : run.cameras) path.emplace_back(p.x(), p.y(), flying_height(p, run.heading_deg, d));
    limit_climb(path, std::tan(base::deg_to_rad(options_.max_climb_deg)));
    std::vector<std::size_t> kept{0};
    if (path.size() > 1) {
      keep_corners(path, 0, path.size() - 1, kSamePath_m, kept);
      kept.push_back(path.size() - 1);
    }
    const double heading =
        plan_.waypoints.empty() ? run.heading_deg : unwrapped(run.heading_deg, plan_.waypoints.back().heading_deg);
    const double spacing = path.size() > 1 ? (path[1] - path[0]).head<2>().norm() : 0.0;
    for (std::size_t k = 0; k < kept.size(); ++k) {
      Waypoint w;
      w.position = path[kept[k]];
      w.heading_deg = heading;
      w.pitch_deg = options_.pitch_deg;
      w.stop = k == 0 || k + 1 == kept.size();
      w.trigger_m = k + 1 < kept.size() ? spacing : 0.0;
      w.photo = path.size() == 1;
      w.role = survey::WaypointRole::lane;
      w.group = run.lane;
      // Views of the stretch that begins here lie on its straight line.
      const std::size_t end = k + 1 < kept.size() ? kept[k + 1] : kept[k] + (path.size() == 1 || k > 0 ? 1 : 0);
      for (std::size_t i = kept[k]; i < end; ++i) {
        survey::Frame view;
        view.id = survey::FrameId(static_cast<std::int64_t>(plan_.views.size()));
        view.camera = camera_.id;
        Vec3 position = path[i];
        if (k + 1 < kept.size()) {
          const Vec3 a = path[kept[k]], b = path[kept[k + 1]];
          const double length = (b - a).head<2>().norm();
          position.z() = a.z() + (b.z() - a.z()) * (length > 0.0 ? (path[i] - a).head<2>().norm() / length : 0.0);
        }
        view.T_world_camera = camera_pose(position, heading, options_.pitch_deg);
        plan_.views.push_back(view);
        plan_.view_waypoint.push_back(plan_.waypoints.size());
      }
      plan_.waypoints.push_back(w);
    }
  }

  const Area& area_;
  const survey::Camera& camera_;
  const SurfaceHeights& surface_;
  const LawnmowerOptions& options_;
  Footprint footprint_;
  double azimuth_ = 0.0;
  double low_ = 0.0, high_ = 0.0, top_ = 0.0;  // 2nd and 98th percentile and highest of the surface in the area
  LawnmowerPlan plan_;
};

}  // namespace

LawnmowerPlan plan_lawnmower(const Area& area, const survey::Camera& camera, const SurfaceHeights& surface,
                             const LawnmowerOptions& options, base::RunContext& ctx) {
  LawnmowerOptions checked = options;
  base::validate(base::bind_options(checked), "lawn-mower");
  if ((options.gsd_m > 0.0) == (options.height_m > 0.0))
    throw base::Error(base::ErrorCode::invalid_argument, "a lawn-mower needs a ground sampling distance or a height")
        .found(options.gsd_m > 0.0 ? "both" : "neither")
        .allowed("--gsd or --height-m");
  check_area(area);
  return Planner(area, camera, surface, options).run(ctx);
}

}  // namespace cairn::planning
