#include "localisation/drift.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <map>

#include "localisation/triangulation.hpp"

namespace cairn::localisation {
namespace {

using geometry::Mat2;
using geometry::Mat3;
using geometry::Vec2;
using geometry::Vec3;

constexpr std::size_t kLeastFrames = 20;
constexpr double kLeastSigma_m = 0.05;
constexpr double kNodeSpacing_s = 5.0;
constexpr double kMostNodes = 200.0;
constexpr double kLongestStep_s = 60.0;    // a longer pause, or a clock that jumps, says no more than this
constexpr double kIndependentBoxes = 3.0;  // of one candidate between two nodes
constexpr std::size_t kLeastBoxes = 8;     // of a candidate: fewer may be a chance meeting
constexpr double kHuber = 1.345;
constexpr int kSteps = 3;

// Where a frame lies between nodes: share of node `first + 1`.
struct Place {
  std::size_t first = 0;
  double share = 0.0;
};

struct Nodes {
  std::vector<Place> of_frame;
  std::size_t count = 1;
  double spacing_s = kNodeSpacing_s;
};

Nodes nodes_of(const PreparedBoxes& prepared) {
  std::vector<double> at(prepared.frames.size(), 0.0);
  for (std::size_t f = 1; f < at.size(); ++f) {
    const double step = 1e-9 * static_cast<double>(prepared.frames[f].time_ns - prepared.frames[f - 1].time_ns);
    at[f] = at[f - 1] + (step >= 0.0 ? std::min(step, kLongestStep_s) : 1.0);
  }
  Nodes nodes;
  nodes.spacing_s = std::max(kNodeSpacing_s, at.back() / (kMostNodes - 1.0));
  nodes.count = static_cast<std::size_t>(at.back() / nodes.spacing_s) + 2;
  for (const double t : at) {
    const double u = t / nodes.spacing_s;
    nodes.of_frame.push_back({static_cast<std::size_t>(u), u - std::floor(u)});
  }
  return nodes;
}

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2), values.end());
  return values[values.size() / 2];
}

// The normal equations of one step.
struct Normals {
  struct Target {
    Mat3 a = Mat3::Zero();
    Vec3 g = Vec3::Zero();
    std::map<std::size_t, Mat3> b;  // by node
  };
  std::vector<Target> targets;
  Eigen::MatrixXd nodes;
  Eigen::VectorXd gradient;
};

class Estimator {
 public:
  Estimator(const PreparedBoxes& prepared, const std::vector<Candidate>& candidates, const LocateOptions& options)
      : prepared_(prepared), candidates_(candidates), nodes_(nodes_of(prepared)) {
    std::vector<double> xy, z;
    for (const auto& frame : prepared.frames) {
      xy.push_back(frame.sigma_xy_m);
      z.push_back(frame.sigma_z_m);
    }
    sigma_ = Vec3(median(xy), median(xy), median(z)).cwiseMax(kLeastSigma_m);
    step_ = sigma_ * std::sqrt(nodes_.spacing_s / options.drift_time_s);
    for (const auto& c : candidates_) centre_.push_back(c.fix.centre);
    offset_ = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(3 * nodes_.count));
    weigh();
  }

  Drift run() {
    Eigen::MatrixXd covariance;
    Normals normals;
    for (int step = 0; step < kSteps; ++step) {
      normals = assemble();
      const Eigen::MatrixXd data = reduced(normals);
      Eigen::VectorXd right = normals.gradient;
      for (const auto& t : normals.targets) {
        if (!(t.a.determinant() > 0.0)) continue;
        const Vec3 part = t.a.inverse() * t.g;
        for (const auto& [k, b] : t.b) right.segment<3>(row(k)) -= b.transpose() * part;
      }
      if (step == 0) choose_walk(data, right);
      const Eigen::MatrixXd before = prior(walk_);
      right += before * offset_;
      const Eigen::LLT<Eigen::MatrixXd> factor(data + before);
      if (factor.info() != Eigen::Success) break;
      const Eigen::VectorXd move = -factor.solve(right);
      if (!move.allFinite()) break;
      offset_ += move;
      for (std::size_t j = 0; j < centre_.size(); ++j) {
        const auto& t = normals.targets[j];
        if (!(t.a.determinant() > 0.0)) continue;
        Vec3 sum = t.g;
        for (const auto& [k, b] : t.b) sum += b * move.segment<3>(row(k));
        centre_[j] -= t.a.inverse() * sum;
      }
      covariance = factor.solve(Eigen::MatrixXd::Identity(move.size(), move.size()));
    }
    return result(normals, covariance);
  }

 private:
  static Eigen::Index row(std::size_t node) { return static_cast<Eigen::Index>(3 * node); }

  // How much each box counts: kIndependentBoxes a candidate and pair of nodes.
  void weigh() {
    for (const auto& c : candidates_) {
      std::map<std::size_t, double> count;
      for (const std::size_t b : c.boxes) count[nodes_.of_frame[prepared_.boxes[b].frame].first] += 1.0;
      std::vector<double> weight;
      for (const std::size_t b : c.boxes)
        weight.push_back(
            c.boxes.size() < kLeastBoxes
                ? 0.0
                : std::min(1.0, kIndependentBoxes / count[nodes_.of_frame[prepared_.boxes[b].frame].first]));
      weight_.push_back(std::move(weight));
    }
  }

  Vec3 offset(std::size_t frame) const {
    const Place& place = nodes_.of_frame[frame];
    return (1.0 - place.share) * offset_.segment<3>(row(place.first)) +
           place.share * offset_.segment<3>(row(place.first + 1));
  }

  // Information of the prior: the offset itself, shared out over all nodes, and its change from node to node, whose
  // standard deviation is `share` of what drift_time_s says.
  Eigen::MatrixXd prior(double share) const {
    const auto size = static_cast<Eigen::Index>(3 * nodes_.count);
    Eigen::MatrixXd p = Eigen::MatrixXd::Zero(size, size);
    for (Eigen::Index i = 0; i < size; ++i) {
      const Eigen::Index axis = i % 3;
      p(i, i) += 1.0 / (sigma_[axis] * sigma_[axis] * static_cast<double>(nodes_.count));
      if (i + 3 >= size) continue;
      const double walk = 1.0 / (share * share * step_[axis] * step_[axis]);
      p(i, i) += walk;
      p(i + 3, i + 3) += walk;
      p(i, i + 3) -= walk;
      p(i + 3, i) -= walk;
    }
    return p;
  }

  // The walk under which the boxes are most likely (the marginal likelihood of the linearised problem): a bias that
  // does not move must not be given room to, or the noise of the boxes would be taken for it.
  void choose_walk(const Eigen::MatrixXd& data, const Eigen::VectorXd& gradient) {
    double best = 0.0;
    bool first = true;
    for (const double share : {0.01, 0.03, 0.1, 0.3, 1.0}) {
      const Eigen::MatrixXd before = prior(share);
      const Eigen::LLT<Eigen::MatrixXd> factor(data + before), alone(before);
      if (factor.info() != Eigen::Success || alone.info() != Eigen::Success) continue;
      const auto log_det = [](const Eigen::LLT<Eigen::MatrixXd>& llt) {
        return 2.0 * llt.matrixLLT().diagonal().array().log().sum();
      };
      const double likelihood = 0.5 * (log_det(alone) - log_det(factor) + gradient.dot(factor.solve(gradient)));
      if (!std::isfinite(likelihood) || (!first && likelihood <= best)) continue;
      best = likelihood;
      walk_ = share;
      first = false;
    }
  }

  Normals assemble() const {
    Normals n;
    n.targets.resize(candidates_.size());
    const auto size = static_cast<Eigen::Index>(3 * nodes_.count);
    n.nodes = Eigen::MatrixXd::Zero(size, size);
    n.gradient = Eigen::VectorXd::Zero(size);
    for (std::size_t j = 0; j < candidates_.size(); ++j)
      for (std::size_t i = 0; i < candidates_[j].boxes.size(); ++i)
        if (weight_[j][i] > 0.0) add(j, candidates_[j].boxes[i], weight_[j][i], n);
    return n;
  }

  void add(std::size_t j, std::size_t box, double weight, Normals& n) const {
    const Box& b = prepared_.boxes[box];
    FrameView frame = prepared_.frames[b.frame];
    frame.view.T_world_camera.translation -= offset(b.frame);
    frame.sigma_xy_m = frame.sigma_z_m = 0.0;  // the offset stands for it
    const auto at = appearance(frame, centre_[j], Mat3::Zero());
    if (!at) return;
    Mat2 covariance = at->covariance;
    covariance.diagonal() += b.sigma_px.cwiseAbs2();
    const Vec2 r = at->pixel - b.centre_px;
    const Mat2 inverse = covariance.inverse();
    const double d = std::sqrt(std::max(0.0, r.dot(inverse * r)));
    if (!std::isfinite(d)) return;
    const double w = weight * (d > kHuber ? kHuber / d : 1.0);
    const auto jacobian = frame.view.jacobian(frame.view.to_camera(centre_[j]));
    const Mat3 m = w * jacobian.transpose() * inverse * jacobian;
    const Vec3 g = w * jacobian.transpose() * inverse * r;
    const Place& place = nodes_.of_frame[b.frame];
    const double share[2] = {1.0 - place.share, place.share};
    auto& t = n.targets[j];
    t.a += m;
    t.g += g;
    for (std::size_t p = 0; p < 2; ++p) {
      const std::size_t k = place.first + p;
      t.b.try_emplace(k, Mat3::Zero()).first->second += share[p] * m;
      n.gradient.segment<3>(row(k)) += share[p] * g;
      for (std::size_t q = 0; q < 2; ++q) n.nodes.block<3, 3>(row(k), row(place.first + q)) += share[p] * share[q] * m;
    }
  }

  static Eigen::MatrixXd reduced(const Normals& n) {
    Eigen::MatrixXd s = n.nodes;
    for (const auto& t : n.targets) {
      if (!(t.a.determinant() > 0.0)) continue;
      const Mat3 inverse = t.a.inverse();
      for (const auto& [k, bk] : t.b)
        for (const auto& [l, bl] : t.b) s.block<3, 3>(row(k), row(l)) -= bk.transpose() * inverse * bl;
    }
    return s;
  }

  Drift result(const Normals& normals, const Eigen::MatrixXd& covariance) const {
    Drift drift;
    const std::size_t frames = prepared_.frames.size();
    // The share of each node in the mean over the frames.
    Eigen::VectorXd mean = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(nodes_.count));
    for (const auto& place : nodes_.of_frame) {
      mean[static_cast<Eigen::Index>(place.first)] += (1.0 - place.share) / static_cast<double>(frames);
      mean[static_cast<Eigen::Index>(place.first + 1)] += place.share / static_cast<double>(frames);
    }
    const auto spread = [&](Eigen::MatrixXd w) -> Mat3 {  // w: 3 x 3n, how the offsets enter
      for (Eigen::Index k = 0; k < mean.size(); ++k) w.middleCols<3>(3 * k) -= mean[k] * Mat3::Identity();
      return covariance.size() > 0 ? Mat3(w * covariance * w.transpose()) : Mat3(Mat3::Zero());
    };
    Vec3 average = Vec3::Zero();
    for (std::size_t f = 0; f < frames; ++f) average += offset(f) / static_cast<double>(frames);
    std::vector<double> node_sigma;
    for (std::size_t k = 0; k < nodes_.count; ++k) {
      Eigen::MatrixXd w = Eigen::MatrixXd::Zero(3, offset_.size());
      w.middleCols<3>(row(k)) = Mat3::Identity();
      node_sigma.push_back(std::sqrt(std::max(0.0, spread(w).trace() / 3.0)));
    }
    double squares = 0.0;
    for (std::size_t f = 0; f < frames; ++f) {
      const Place& place = nodes_.of_frame[f];
      drift.offset_m.push_back(offset(f) - average);
      squares += drift.offset_m.back().squaredNorm();
      drift.sigma_m.push_back(std::max(node_sigma[place.first], node_sigma[place.first + 1]));
    }
    drift.rms_m = std::sqrt(squares / static_cast<double>(frames));
    for (const auto& t : normals.targets) {
      if (!(t.a.determinant() > 0.0)) {
        drift.covariance.emplace_back(Mat3::Zero());
        continue;
      }
      Eigen::MatrixXd w = Eigen::MatrixXd::Zero(3, offset_.size());
      const Mat3 inverse = t.a.inverse();
      for (const auto& [k, b] : t.b) w.middleCols<3>(row(k)) += inverse * b;
      const Mat3 c = spread(std::move(w));
      drift.covariance.push_back(c.allFinite() ? Mat3(0.5 * (c + c.transpose())) : Mat3(Mat3::Zero()));
    }
    return drift;
  }

  const PreparedBoxes& prepared_;
  const std::vector<Candidate>& candidates_;
  Nodes nodes_;
  Vec3 sigma_, step_;
  double walk_ = 0.01;  // of step_
  std::vector<Vec3> centre_;
  std::vector<std::vector<double>> weight_;
  Eigen::VectorXd offset_;
};

}  // namespace

bool drifts(const PreparedBoxes& prepared, const LocateOptions& options) {
  if (!(options.drift_time_s > 0.0) || !prepared.video || prepared.frames.size() < kLeastFrames) return false;
  std::vector<double> sigmas;
  for (const auto& frame : prepared.frames) sigmas.push_back(frame.sigma_xy_m);
  return median(std::move(sigmas)) >= kLeastSigma_m;
}

Drift estimate_drift(const PreparedBoxes& prepared, const std::vector<Candidate>& candidates,
                     const LocateOptions& options) {
  return Estimator(prepared, candidates, options).run();
}

void remove_drift(const Drift& drift, PreparedBoxes& prepared) {
  for (std::size_t f = 0; f < prepared.frames.size(); ++f) {
    FrameView& frame = prepared.frames[f];
    frame.view.T_world_camera.translation -= drift.offset_m[f];
    const double left = std::min(drift.sigma_m[f], frame.sigma_xy_m);
    frame.sigma_xy_m = frame.sigma_z_m = std::max(left, 0.02);
  }
}

}  // namespace cairn::localisation
