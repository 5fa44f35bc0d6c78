#include "ground/obstacle_track.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace cairn::ground {
namespace {

using geometry::Mat2;
using geometry::Vec2;

constexpr std::size_t kSizesKept = 65;   // looks that the medians of width and height rest on
constexpr std::size_t kRecentKept = 32;  // looks that a line rests on, at most
constexpr double kNs = 1e-9;

double seconds(std::int64_t later, std::int64_t earlier) {
  return kNs * static_cast<double>(later - earlier);
}

struct Middle {
  double value = 0.0, sigma = 0.0;
};

// Median, and its standard error from the median absolute deviation; 0 with fewer than 3 values.
Middle middle_of(std::vector<double> values) {
  if (values.empty()) return {};
  const auto median = [](std::vector<double>& v) {
    std::sort(v.begin(), v.end());
    const std::size_t n = v.size();
    return n % 2 == 1 ? v[n / 2] : 0.5 * (v[n / 2 - 1] + v[n / 2]);
  };
  const double value = median(values);
  if (values.size() < 3) return {value, 0.0};
  for (double& v : values) v = std::abs(v - value);
  constexpr double kMadToSigma = 1.4826, kMedianLoss = 1.2533;  // of normal values
  return {value, kMadToSigma * kMedianLoss * median(values) / std::sqrt(static_cast<double>(values.size()))};
}

void keep_latest(std::vector<double>& values, double value) {
  if (!(value > 0.0)) return;
  if (values.size() == kSizesKept) values.erase(values.begin());
  values.push_back(value);
}

}  // namespace

ObstacleTrack::ObstacleTrack(std::int64_t id_, survey::ObstacleKind kind_, const Look& look, const MotionRules& rules)
    : id(id_), kind(kind_), first_seen_ns(look.time_ns), last_seen_ns(look.time_ns), last_in_view_ns(look.time_ns) {
  add(look, rules);
}

void ObstacleTrack::add(const Look& look, const MotionRules& rules) {
  const Mat2 information = look.covariance.inverse();
  information_ += information;
  weighted_ += information * look.position;
  const double weight = information.trace();
  up_sum_ += weight * look.up;
  up_weight_ += weight;
  score_sum_ += look.score;
  votes_[look.object_class] += std::max(look.score, 1e-3);
  keep_latest(widths_, look.width_m);
  keep_latest(heights_, look.height_m);
  ++looks;
  first_seen_ns = std::min(first_seen_ns, look.time_ns);
  last_seen_ns = std::max(last_seen_ns, look.time_ns);
  last_in_view_ns = std::max(last_in_view_ns, look.time_ns);
  if (!rules.on) return;
  const auto place = std::upper_bound(recent_.begin(), recent_.end(), look.time_ns,
                                      [](std::int64_t t, const Look& l) { return t < l.time_ns; });
  recent_.insert(place, look);
  while (recent_.size() > kRecentKept || seconds(last_seen_ns, recent_.front().time_ns) > rules.window_s)
    recent_.pop_front();
  fit_line(rules);
}

// Least squares of p + v t over the recent looks, t from the latest. With one covariance a look the two axes couple.
void ObstacleTrack::fit_line(const MotionRules& rules) {
  line_.reset();
  if (recent_.size() >= 2 && recent_.front().time_ns < recent_.back().time_ns) {
    using Mat4 = Eigen::Matrix4d;
    using Vec4 = Eigen::Vector4d;
    const Mat2 common = rules.systematic_m * rules.systematic_m * Mat2::Identity();
    Mat4 normal = Mat4::Zero();
    Vec4 right = Vec4::Zero();
    Mat2 rest_information = Mat2::Zero();
    Vec2 rest_right = Vec2::Zero();
    // Relative to the latest look, so that coordinates of kilometres cost no digits.
    const Vec2 origin = recent_.back().position;
    for (const Look& look : recent_) {
      const double t = seconds(look.time_ns, last_seen_ns);
      const Mat2 w = (look.covariance + common).inverse();
      Eigen::Matrix<double, 2, 4> a;
      a << Mat2::Identity(), t * Mat2::Identity();
      normal += a.transpose() * w * a;
      right += a.transpose() * w * (look.position - origin);
      rest_information += w;
      rest_right += w * (look.position - origin);
    }
    const Eigen::LDLT<Mat4> factor(normal);
    const Vec4 x = factor.solve(right);
    const Vec2 rest = rest_information.inverse() * rest_right;
    Line line;
    line.covariance = factor.solve(Mat4::Identity());
    line.position = origin + x.head<2>();
    line.velocity = x.tail<2>();
    line.chi2_fall = x.dot(right) - rest.dot(rest_right);
    if (x.allFinite() && line.covariance.allFinite() && line.velocity.norm() <= rules.max_speed_m_s) line_ = line;
  }
  constexpr std::size_t kLeastLooks = 4;
  if (!moving) {
    moving = line_ && recent_.size() >= kLeastLooks && line_->velocity.norm() >= rules.min_speed_m_s &&
             line_->chi2_fall >= rules.chi2;
  } else if (!line_ || line_->velocity.norm() < rules.min_speed_m_s || line_->chi2_fall < 0.5 * rules.chi2) {
    moving = false;
    rest_again();
  }
}

// What was seen before the motion was of another place.
void ObstacleTrack::rest_again() {
  information_.setZero();
  weighted_.setZero();
  for (const Look& look : recent_) {
    const Mat2 information = look.covariance.inverse();
    information_ += information;
    weighted_ += information * look.position;
  }
}

void ObstacleTrack::merge(const ObstacleTrack& other) {
  information_ += other.information_;
  weighted_ += other.weighted_;
  up_sum_ += other.up_sum_;
  up_weight_ += other.up_weight_;
  score_sum_ += other.score_sum_;
  for (const auto& [name, votes] : other.votes_) votes_[name] += votes;
  for (const double width : other.widths_) keep_latest(widths_, width);
  for (const double height : other.heights_) keep_latest(heights_, height);
  looks += other.looks;
  misses = std::min(misses, other.misses);
  log_odds = std::max(log_odds, other.log_odds);
  confirmed = confirmed || other.confirmed;
  first_seen_ns = std::min(first_seen_ns, other.first_seen_ns);
  if (other.last_seen_ns > last_seen_ns) {
    last_seen_ns = other.last_seen_ns;
    recent_ = other.recent_;
    line_ = other.line_;
  }
  last_in_view_ns = std::max(last_in_view_ns, other.last_in_view_ns);
}

Place ObstacleTrack::at_rest() const {
  const Mat2 covariance = information_.inverse();
  return {covariance * weighted_, covariance};
}

std::optional<Place> ObstacleTrack::moved_to(std::int64_t time_ns, const MotionRules& rules) const {
  if (!line_) return std::nullopt;
  const double t = seconds(time_ns, last_seen_ns);
  Eigen::Matrix<double, 2, 4> a;
  a << Mat2::Identity(), t * Mat2::Identity();
  const double drift = 0.5 * rules.acceleration_m_s2 * t * t;
  return Place{line_->position + t * line_->velocity,
               a * line_->covariance * a.transpose() + drift * drift * Mat2::Identity()};
}

Place ObstacleTrack::at(std::int64_t time_ns, const MotionRules& rules) const {
  if (moving)
    if (const auto place = moved_to(time_ns, rules)) return *place;
  return at_rest();
}

const std::string& ObstacleTrack::object_class() const {
  return std::max_element(votes_.begin(), votes_.end(),
                          [](const auto& a, const auto& b) { return a.second < b.second; })
      ->first;
}

double ObstacleTrack::width() const {
  return middle_of(widths_).value;
}

survey::Obstacle ObstacleTrack::record(const MotionRules& rules) const {
  survey::Obstacle o;
  o.target = survey::TargetId(id);
  o.object_class = object_class();
  o.kind = kind;
  const Place place = at(last_seen_ns, rules);
  o.position = {place.position.x(), place.position.y(), up_sum_ / up_weight_};
  o.covariance = place.covariance + rules.systematic_m * rules.systematic_m * Mat2::Identity();
  o.covariance = (0.5 * (o.covariance + o.covariance.transpose())).eval();
  const Middle width_seen = middle_of(widths_), height_seen = middle_of(heights_);
  o.width_m = width_seen.value;
  o.sigma_width_m = width_seen.sigma;
  o.height_m = height_seen.value;
  o.sigma_height_m = height_seen.sigma;
  o.score = score_sum_ / static_cast<double>(looks);
  o.observations = looks;
  o.misses = misses;
  o.first_seen_ns = first_seen_ns;
  o.last_seen_ns = last_seen_ns;
  if (moving && line_) {
    o.velocity = line_->velocity;
    o.velocity_covariance = line_->covariance.bottomRightCorner<2, 2>();
  }
  return o;
}

}  // namespace cairn::ground
