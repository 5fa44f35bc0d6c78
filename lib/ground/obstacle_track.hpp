// One object of the obstacle map: its looks fused.
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "geometry/vec.hpp"
#include "survey/obstacle.hpp"

namespace cairn::ground {

struct Look {
  std::int64_t time_ns = 0;
  geometry::Vec2 position = geometry::Vec2::Zero();    // local east and north, m
  geometry::Mat2 covariance = geometry::Mat2::Zero();  // positive definite, m^2
  double up = 0.0;                                     // of the foot, m
  double width_m = 0.0, height_m = 0.0;                // 0 = not known
  double score = 0.0;
  std::string object_class;
};

struct Place {
  geometry::Vec2 position = geometry::Vec2::Zero();
  geometry::Mat2 covariance = geometry::Mat2::Zero();
};

struct MotionRules {
  bool on = true;
  double window_s = 3.0, min_speed_m_s = 0.15, max_speed_m_s = 4.0, chi2 = 18.0, acceleration_m_s2 = 0.3;
  double systematic_m = 0.1;
};

// Looks at an object at rest add up as information (independent of their order); a straight line p + v t through those
// of the last seconds is its motion.
class ObstacleTrack {
 public:
  ObstacleTrack(std::int64_t id, survey::ObstacleKind kind, const Look& look, const MotionRules& rules);

  void add(const Look& look, const MotionRules& rules);
  // Takes the other's looks in. The other is of the same kind, and at rest or not as this one.
  void merge(const ObstacleTrack& other);

  [[nodiscard]] Place at_rest() const;
  // Where the line has it at a time; empty with fewer than two looks in the window, or too fast a line.
  [[nodiscard]] std::optional<Place> moved_to(std::int64_t time_ns, const MotionRules& rules) const;
  // The better supported of the two.
  [[nodiscard]] Place at(std::int64_t time_ns, const MotionRules& rules) const;

  // Without misses and evidence, which the map keeps.
  [[nodiscard]] survey::Obstacle record(const MotionRules& rules) const;
  [[nodiscard]] const std::string& object_class() const;
  [[nodiscard]] double width() const;

  std::int64_t id = 0;
  survey::ObstacleKind kind = survey::ObstacleKind::obstacle;
  std::int64_t first_seen_ns = 0, last_seen_ns = 0;
  std::int64_t last_in_view_ns = 0;  // seen or missed
  std::size_t looks = 0, misses = 0;
  double log_odds = 0.0;
  bool moving = false;
  bool confirmed = false;

 private:
  struct Line {
    geometry::Vec2 position = geometry::Vec2::Zero(), velocity = geometry::Vec2::Zero();  // at last_seen_ns
    Eigen::Matrix4d covariance = Eigen::Matrix4d::Zero();                                 // of position, velocity
    double chi2_fall = 0.0;
  };
  void fit_line(const MotionRules& rules);
  void rest_again();

  geometry::Mat2 information_ = geometry::Mat2::Zero();
  geometry::Vec2 weighted_ = geometry::Vec2::Zero();
  double up_sum_ = 0.0, up_weight_ = 0.0, score_sum_ = 0.0;
  std::map<std::string, double> votes_;
  std::vector<double> widths_, heights_;  // the latest
  std::deque<Look> recent_;               // ascending in time
  std::optional<Line> line_;
};

}  // namespace cairn::ground
