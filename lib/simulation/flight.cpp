#include "simulation/flight.hpp"

#include <algorithm>
#include <cmath>
#include <deque>
#include <functional>
#include <map>
#include <numbers>
#include <utility>

#include "base/angle.hpp"
#include "base/error.hpp"
#include "camera/dji_pose.hpp"
#include "camera/projection.hpp"

namespace cairn::simulation {
namespace {

using base::Error;
using base::ErrorCode;
using geometry::Vec2;
using geometry::Vec3;

struct Attitude {
  Vec3 position;
  double heading_deg = 0.0;  // of the vehicle
  double gamma_deg = 60.0;   // of the camera
};

// Part of the ring with sign * x <= limit (Sutherland-Hodgman).
geometry::Ring clipped(const geometry::Ring& ring, double sign, double limit) {
  geometry::Ring result;
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const Vec2 &a = ring[i], &b = ring[(i + 1) % ring.size()];
    const double da = sign * a.x() - limit, db = sign * b.x() - limit;
    if (da <= 0.0) result.push_back(a);
    if ((da < 0.0) != (db < 0.0) && da != db) result.push_back(a + da / (da - db) * (b - a));
  }
  return result;
}

Vec2 turned(const Vec2& p, double angle) {
  return {std::cos(angle) * p.x() - std::sin(angle) * p.y(), std::sin(angle) * p.x() + std::cos(angle) * p.y()};
}

double wrapped_deg(double angle) {
  return std::remainder(angle, 360.0);
}

double heading_of(const Vec2& way) {
  return base::azimuth_deg(way.x(), way.y());
}

class Pilot {
 public:
  Pilot(const Scene& scene, const Ground& ground, const std::vector<PlacedObject>& objects)
      : scene_(scene), ground_(ground), objects_(objects) {}

  std::vector<Exposure> fly() {
    for (flight_index_ = 0; flight_index_ < scene_.flights.size(); ++flight_index_) {
      flight_ = &scene_.flights[flight_index_];
      begin();
      switch (flight_->kind) {
        case FlightKind::lawn_mower: lawn_mower(); break;
        case FlightKind::orbit: orbit_flight(); break;
        case FlightKind::waypoints: waypoints(); break;
      }
    }
    return std::move(exposures_);
  }

 private:
  void begin() {
    camera_ = 0;
    for (std::size_t i = 0; i < scene_.cameras.size(); ++i)
      if (scene_.cameras[i].name == flight_->camera) camera_ = i;
    next_s_ = time_s_;
    next_m_ = 0.0;
    gamma_ = flight_->gamma_deg.value_or(scene_.mount.gamma_deg);
    searching_ = false;
  }

  // ---- motion

  // Follows `way` (seconds since now -> attitude) for `duration_s` at `speed` and takes pictures. Returns the time it
  // was interrupted at, or `duration_s`.
  double advance(double duration_s, double speed, bool record, const std::function<Attitude(double)>& way) {
    constexpr double kClock = 1e-9;  // s: rounding of sums of intervals
    double flown = duration_s;
    if (record) {
      const bool video = flight_->rate_hz > 0.0;
      while (true) {
        const double s = video ? next_s_ - time_s_ : (speed > 0.0 ? next_m_ / speed : duration_s + 1.0);
        if (s > duration_s + kClock) break;
        const Attitude a = way(std::clamp(s, 0.0, duration_s));
        expose(time_s_ + s, a);
        if (video) next_s_ += 1.0 / flight_->rate_hz;
        else next_m_ += flight_->photo_spacing_m;
        if (searching_ && look_out(time_s_ + s, a)) {
          flown = std::clamp(s, 0.0, duration_s);
          break;
        }
      }
      if (flight_->rate_hz <= 0.0 && speed > 0.0) next_m_ -= flown * speed;
    } else {
      next_s_ = std::max(next_s_, time_s_ + duration_s);
    }
    const Attitude end = way(flown);
    position_ = end.position;
    heading_ = end.heading_deg;
    time_s_ += flown;
    return flown;
  }

  void turn_to(double heading, bool record) {
    if (!started_) {
      heading_ = heading;
      started_ = true;
      return;
    }
    const double from = heading_, by = wrapped_deg(heading - heading_);
    if (std::abs(by) < 1e-9) return;
    const Vec3 at = position_;
    const double duration = std::abs(by) / flight_->turn_rate_deg_s;
    const bool searching = std::exchange(searching_, false);
    advance(duration, 0.0, record, [&](double s) { return Attitude{at, from + by * s / duration, gamma_}; });
    searching_ = searching;
  }

  // Straight to `to`; true when it arrived, false when the search was interrupted.
  bool line_to(const Vec3& to, double heading, bool record) {
    turn_to(heading, record);
    const Vec3 from = position_;
    const double length = (to - from).norm();
    if (length < 1e-9) return true;
    const double duration = length / flight_->speed_m_s;
    const double flown = advance(duration, flight_->speed_m_s, record, [&](double s) {
      return Attitude{on_height(from + (to - from) * std::min(1.0, s / duration)), heading, gamma_};
    });
    return flown >= duration;
  }

  double heading_to(const Vec3& to) const {
    const Vec2 way = (to - position_).head<2>();
    if (flight_->heading_deg) return *flight_->heading_deg;
    return way.norm() < 1e-6 ? heading_ : heading_of(way);
  }

  void go_to(const Vec3& to) {
    if (!started_) {
      position_ = to;
      return;
    }
    line_to(to, heading_to(to), flight_->record_transit);
    next_s_ = std::max(next_s_, time_s_);
  }

  // ---- heights

  [[nodiscard]] double ground_at(const Vec2& place) const {
    const auto up = ground_.height(place);
    if (!up)
      throw Error(ErrorCode::failed_precondition, "a flight leaves the ground that its height refers to")
          .record("flights[" + std::to_string(flight_index_) + "]")
          .hint("Enlarge the terrain, or use the height reference \"world\"");
    return *up;
  }
  [[nodiscard]] Vec3 on_height(const Vec3& p) const {
    if (flight_->height_reference != HeightReference::ground) return p;
    const double above = flight_->kind == FlightKind::waypoints ? 0.0 : flight_->height_m;
    if (flight_->kind == FlightKind::waypoints) return p;  // its own heights are already above the ground
    return {p.x(), p.y(), ground_at(p.head<2>()) + above};
  }

  // ---- patterns

  void lawn_mower() {
    const double mean = ground_.mean_height(flight_->area);
    plane_ = flight_->height_m + (flight_->height_reference == HeightReference::world ? 0.0 : mean);
    const double spacing =
        flight_->lane_spacing_m > 0.0 ? flight_->lane_spacing_m : spacing_from_overlap(plane_ - mean);
    const auto lanes = lawn_mower_lanes(flight_->area, flight_->lane_azimuth_deg, spacing);
    bool first = true;
    for (const auto& [a, b] : lanes) {
      const Vec3 from = on_height({a.x(), a.y(), plane_}), to = on_height({b.x(), b.y(), plane_});
      if (first) {
        go_to(from);
        searching_ = flight_->circles.has_value();
      } else {
        search_to(from);
      }
      first = false;
      search_to(to);
    }
    searching_ = false;
  }

  // Flies on after each interruption.
  void search_to(const Vec3& to) {
    const double heading = heading_to(to);
    while (!line_to(to, heading, true)) {
      const Vec3 here = position_;
      while (!waiting_.empty()) {
        const std::size_t object = waiting_.front();
        waiting_.pop_front();
        circle(object, here);
      }
      searching_ = true;
    }
  }

  void circle(std::size_t object, const Vec3& back) {
    const EstimationCircles& rule = *flight_->circles;
    const Vec3 centre = objects_[object].truth.cylinder.centre();
    const double above = position_.z() - centre.z();
    searching_ = false;
    circled_ = objects_[object].truth.id;
    if (above > 0.1)
      orbit(centre, above / std::tan(base::deg_to_rad(rule.gamma_0_deg)), rule.turns, rule.clockwise,
            rule.record_transit);
    const Vec2 way = (back - position_).head<2>();
    line_to(back, way.norm() < 1e-6 ? heading_ : heading_of(way), rule.record_transit);
    next_s_ = std::max(next_s_, time_s_);
    circled_ = {};
  }

  void orbit_flight() {
    Vec3 centre = flight_->centre;
    if (!flight_->about.empty()) {
      const PlacedObject* object = nullptr;
      for (const auto& candidate : objects_)
        if (candidate.name == flight_->about) object = &candidate;
      if (object == nullptr)
        throw Error(ErrorCode::failed_precondition, "an orbit is about an object that is not in the scene")
            .record("flights[" + std::to_string(flight_index_) + "].about")
            .found(flight_->about);
      centre = object->truth.cylinder.centre();
    }
    plane_ =
        flight_->height_m + (flight_->height_reference == HeightReference::world ? 0.0 : ground_at(centre.head<2>()));
    const double above = plane_ - centre.z();
    const double radius =
        flight_->radius_m > 0.0 ? flight_->radius_m : above / std::tan(base::deg_to_rad(flight_->gamma_0_deg));
    if (!(radius > 0.0))
      throw Error(ErrorCode::failed_precondition, "an orbit lies below its centre and has no radius of its own")
          .record("flights[" + std::to_string(flight_index_) + "]")
          .hint("Raise height_m, or give radius_m");
    if (flight_->aim_at_centre) gamma_ = base::rad_to_deg(std::atan2(above, radius));
    if (!started_) position_ = {centre.x(), centre.y() - radius, plane_};
    orbit({centre.x(), centre.y(), centre.z()}, radius, flight_->turns, flight_->clockwise, flight_->record_transit);
  }

  // Enters the circle at its closest point, the camera towards the axis.
  void orbit(const Vec3& centre, double radius, double turns, bool clockwise, bool record_transit) {
    const double z = flight_->circles && circled_.valid() ? position_.z() : plane_;
    Vec2 out = (position_ - centre).head<2>();
    out = out.norm() < 1e-6 ? Vec2(0.0, -1.0) : Vec2(out.normalized());
    const Vec2 entry = centre.head<2>() + radius * out;
    const double start = std::atan2(out.y(), out.x());
    const auto inward = [&](double angle) {
      return flight_->heading_deg && !circled_.valid()
                 ? *flight_->heading_deg
                 : heading_of(Vec2(-std::cos(angle), -std::sin(angle))) - scene_.mount.yaw_deg;
    };
    line_to({entry.x(), entry.y(), z}, inward(start), record_transit);
    next_s_ = std::max(next_s_, time_s_);
    const double sweep = (clockwise ? -1.0 : 1.0) * turns * 2.0 * std::numbers::pi;
    const double duration = std::abs(sweep) * radius / flight_->speed_m_s;
    advance(duration, flight_->speed_m_s, true, [&](double s) {
      const double angle = start + sweep * s / duration;
      const Vec3 p(centre.x() + radius * std::cos(angle), centre.y() + radius * std::sin(angle), z);
      return Attitude{on_height(p), inward(angle), gamma_};
    });
  }

  void waypoints() {
    bool first = true;
    for (const Vec3& point : flight_->waypoints) {
      Vec3 to = point;
      if (flight_->height_reference != HeightReference::world) to.z() += ground_at(point.head<2>());
      if (first) go_to(to);
      else line_to(to, heading_to(to), true);
      first = false;
    }
  }

  // ---- camera

  [[nodiscard]] geometry::RigidTransform pose(const Attitude& a) const {
    const camera::GimbalAngles angles{base::Angle::from_deg(a.heading_deg + scene_.mount.yaw_deg),
                                      base::Angle::from_deg(-a.gamma_deg), base::Angle()};
    return {camera::enu_from_camera(angles), a.position};
  }

  void expose(double time_s, const Attitude& a) {
    exposures_.push_back({time_s, camera_, flight_index_, circled_, pose(a)});
  }

  // Notes which sought objects' centres are in view; true when one was seen for long enough.
  bool look_out(double time_s, const Attitude& a) {
    const double step = std::min(time_s - seen_at_s_, 2.0 / std::max(0.5, flight_->rate_hz));
    seen_at_s_ = time_s;
    const auto T = pose(a);
    for (std::size_t i = 0; i < objects_.size(); ++i) {
      if (!objects_[i].truth.sought || done_[i]) continue;
      const auto pixel = camera::project_world(scene_.cameras[camera_], T, objects_[i].truth.cylinder.centre());
      if (!pixel || !camera::inside_image(scene_.cameras[camera_], *pixel, 0.05)) continue;
      seen_s_[i] += step;
      if (seen_s_[i] < flight_->circles->seen_s) continue;
      done_[i] = true;
      waiting_.push_back(i);
    }
    return !waiting_.empty();
  }

  // Width of the image on level ground, along the row through its middle, less what must overlap.
  [[nodiscard]] double spacing_from_overlap(double above_ground) const {
    const auto& camera = scene_.cameras[camera_];
    const auto w = static_cast<double>(camera.width_px), h = static_cast<double>(camera.height_px);
    const auto T = pose({{0.0, 0.0, above_ground}, 0.0, gamma_});
    const auto left = camera::pixel_ray(camera, T, {0.0, 0.5 * h}), right = camera::pixel_ray(camera, T, {w, 0.5 * h});
    constexpr double kGrazing = -0.05;  // rise of a ray: 3 deg below the horizon
    if (!(above_ground > 0.0) || !left || !right || left->direction.z() > kGrazing || right->direction.z() > kGrazing)
      throw Error(ErrorCode::failed_precondition, "side_overlap needs a camera above the ground that looks at it")
          .record("flights[" + std::to_string(flight_index_) + "].side_overlap")
          .hint("Give lane_spacing_m");
    const auto on_ground = [&](const geometry::Ray& ray) {
      return Vec2(ray.direction.head<2>() * (above_ground / -ray.direction.z()));
    };
    return std::max(0.01, (on_ground(*left) - on_ground(*right)).norm() * (1.0 - flight_->side_overlap));
  }

  const Scene& scene_;
  const Ground& ground_;
  const std::vector<PlacedObject>& objects_;
  const Flight* flight_ = nullptr;
  std::size_t flight_index_ = 0, camera_ = 0;
  std::vector<Exposure> exposures_;
  Vec3 position_ = Vec3::Zero();
  double heading_ = 0.0, gamma_ = 60.0, plane_ = 0.0;
  double time_s_ = 0.0;
  double next_s_ = 0.0, next_m_ = 0.0;  // time, and way still to go, of the next picture
  bool started_ = false, searching_ = false;
  survey::ObjectId circled_;
  double seen_at_s_ = 0.0;
  std::map<std::size_t, double> seen_s_;
  std::map<std::size_t, bool> done_;
  std::deque<std::size_t> waiting_;
};

}  // namespace

std::vector<std::pair<Vec2, Vec2>> lawn_mower_lanes(const geometry::Ring& area, double azimuth_deg, double spacing) {
  const double angle = base::deg_to_rad(azimuth_deg);  // turns the lanes' direction to north
  geometry::Ring ring;
  for (const Vec2& p : area) ring.push_back(turned(p, angle));
  const auto [lo, hi] =
      std::minmax_element(ring.begin(), ring.end(), [](const Vec2& a, const Vec2& b) { return a.x() < b.x(); });
  const double west = lo->x(), width = hi->x() - west;
  const double lanes = std::max(1.0, std::ceil(width / spacing - 1e-9)), strip = width / lanes;
  std::vector<std::pair<Vec2, Vec2>> result;
  for (double k = 0.0; k < lanes; k += 1.0) {
    const double left = west + k * strip;
    const geometry::Ring part = clipped(clipped(ring, 1.0, left + strip), -1.0, -left);
    if (part.empty()) continue;
    double south = part[0].y(), north = south;
    for (const Vec2& p : part) {
      south = std::min(south, p.y());
      north = std::max(north, p.y());
    }
    const Vec2 a = turned({left + 0.5 * strip, south}, -angle), b = turned({left + 0.5 * strip, north}, -angle);
    if (result.size() % 2 == 0) result.emplace_back(a, b);
    else result.emplace_back(b, a);
  }
  return result;
}

std::vector<Exposure> fly(const Scene& scene, const Ground& ground, const std::vector<PlacedObject>& objects) {
  return Pilot(scene, ground, objects).fly();
}

}  // namespace cairn::simulation
