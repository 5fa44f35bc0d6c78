#include "segmentation/rock_patch.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "base/number_text.hpp"
#include "geometry/kd_tree.hpp"
#include "segmentation/min_cut.hpp"
#include "segmentation/patch_graph.hpp"

namespace cairn::segmentation {
namespace {

using geometry::Vec2;
using geometry::Vec3;

constexpr float kKnown = 1e4F;         // cost of parting a node from what it is known to be
constexpr double kRing = 0.4;          // m of surroundings beyond the margin
constexpr double kBandStep = 0.1;      // of the height: bounds slide by this
constexpr double kBandWidth = 0.35;    // of the height: between what is rock and what is not
constexpr double kFootDiscount = 0.6;  // worth of a crease on the ground against one above it
// Where the foot lies over a located cylinder's height: between these, or off by a spread.
constexpr double kLowFoot = -0.1, kHighFoot = 0.27, kFootSpread = 0.07;
constexpr double kNearlyAsGood = 0.75;    // of the bend of the best crease
constexpr float kLeastCapacity = 0.003F;  // of the cost of a cut on the flat
constexpr double kBasalSpacings = 1.5;    // points this near to the line are basal contact
constexpr double kRelabelSpacings = 8.0;  // and this near they are told by the surfaces at the line
constexpr std::uint32_t kNowhere = 0xffffffffU;

struct Cut {
  std::vector<std::uint8_t> rock;  // one a node
  double concavity = 0.0;          // mean along the cut
  double height = 0.0;             // of the cut above the ground, mean
  Vec2 middle = Vec2::Zero();
  double top = 0.0;  // share of the height that was taken for rock from the start
  bool any = false;
  [[nodiscard]] double worth(double ground_height) const {
    return height < ground_height ? kFootDiscount * concavity : concavity;
  }
};

class Patch {
 public:
  Patch(const PatchInput& input, const RockPatchOptions& options, PatchResult& result)
      : in_(input), options_(options), result_(result) {}

  void run() {
    result_.labels.assign(in_.points.size(), Label::unlabelled);
    result_.probability.assign(in_.points.size(), 0.0F);
    if (!gather() || !find_ground() || !is_surface()) return;
    build();
    Cut cut = best_cut(in_.centre);
    // Once more about the foot's own middle, which tells outward better.
    if (cut.any)
      if (Cut second = best_cut(cut.middle, cut.top - 0.15, cut.top + 0.15);
          second.any && second.worth(foot_height_) >= 0.9 * cut.worth(foot_height_))
        cut = std::move(second);
    if (!cut.any || cut.concavity < options_.least_concavity) {
      fail("no_contact", "no crease closes around a foot (mean bend " + base::to_fixed(cut.concavity, 3) + ", " +
                             base::to_fixed(options_.least_concavity, 3) + " needed)");
      return;
    }
    result_.concavity = cut.concavity;
    rock_ = std::move(cut.rock);
    pedestal_ = cut.height < foot_height_ ? std::vector<std::uint8_t>(graph_.size(), 0) : find_pedestal();
    refine(cut.middle);
    locate_contact();
    label_points();
  }

 private:
  void fail(const char* reason, std::string message) {
    result_.reason = reason;
    result_.message = std::move(message);
  }

  bool gather() {
    const double reach = in_.radius + options_.margin_m + kRing;
    for (std::size_t i = 0; i < in_.points.size(); ++i) {
      const Vec3& p = in_.points[i];
      if (!p.allFinite() || (p.head<2>() - in_.centre).squaredNorm() > reach * reach) continue;
      index_.push_back(static_cast<std::uint32_t>(i));
      points_.push_back(p);
    }
    if (points_.empty()) {
      fail("no_points", "no point within " + base::to_fixed(reach, 2) + " m");
      return false;
    }
    result_.spacing = point_spacing(points_);
    if (result_.spacing <= 0.0) {  // points that stand more than once
      auto unique = points_;
      const auto less = [](const Vec3& a, const Vec3& b) {
        return std::tie(a.x(), a.y(), a.z()) < std::tie(b.x(), b.y(), b.z());
      };
      std::sort(unique.begin(), unique.end(), less);
      unique.erase(std::unique(unique.begin(), unique.end()), unique.end());
      if (unique.size() < points_.size()) result_.notes.emplace_back("duplicate_points");
      result_.spacing = point_spacing(unique);
      distinct_ = unique.size();
    } else {
      distinct_ = points_.size();
    }
    if (distinct_ < 3) {
      fail("two_points", std::to_string(distinct_) + " distinct points are no surface");
      return false;
    }
    geometry::Mat3 scatter = geometry::Mat3::Zero();
    Vec3 mean = Vec3::Zero();
    for (const Vec3& p : points_) mean += p / static_cast<double>(points_.size());
    for (const Vec3& p : points_) scatter += (p - mean) * (p - mean).transpose();
    const Eigen::SelfAdjointEigenSolver<geometry::Mat3> solver(scatter);
    if (solver.eigenvalues()[0] <= 1e-9 * solver.eigenvalues()[2]) {
      fail("planar", "all points lie in a plane");
      return false;
    }
    return true;
  }

  bool find_ground() {
    const double inner = in_.radius + options_.margin_m;
    std::vector<Vec3> around;
    for (const Vec3& p : points_)
      if ((p.head<2>() - in_.centre).norm() > inner) around.push_back(p);
    const auto ground = fit_ground(around, in_.centre);
    if (ground && ground->sectors >= 3) {
      result_.ground = *ground;
    } else {
      // Nothing around it was mapped: what lies lowest bounds the height.
      std::vector<double> z;
      for (const Vec3& p : points_) z.push_back(p.z());
      const auto low = z.begin() + static_cast<std::ptrdiff_t>(z.size() / 50);
      std::nth_element(z.begin(), low, z.end());
      result_.ground.centre = in_.centre;
      result_.ground.up_at_centre = *low;
      result_.notes.emplace_back("ground_not_seen");
    }
    std::size_t high = 0;
    for (const Vec3& p : points_) {
      if ((p.head<2>() - in_.centre).norm() > in_.radius) continue;
      result_.height = std::max(result_.height, result_.ground.height_above(p));
      high += result_.ground.height_above(p) > options_.min_height_m;
    }
    foot_height_ = std::clamp(3.0 * result_.ground.noise, 0.08, std::max(0.08, 0.12 * result_.height));
    if (result_.height < std::max(options_.min_height_m, 3.0 * result_.ground.noise)) {
      fail("not_above_ground", "nothing stands " + base::to_fixed(options_.min_height_m, 2) +
                                   " m above the ground (noise " + base::to_fixed(result_.ground.noise, 3) + " m)");
      return false;
    }
    if (high < static_cast<std::size_t>(options_.min_points)) {
      fail("too_few_points",
           std::to_string(high) + " points stand above the ground, " + std::to_string(options_.min_points) + " needed");
      return false;
    }
    return true;
  }

  // Rocks have a skin; shrubs and noise fill a volume.
  bool is_surface() {
    constexpr std::size_t kSample = 400, kNeighbours = 20;
    constexpr double kThick = 0.12;      // least over the sum of the scatter's eigenvalues: a ball has a third
    constexpr double kThickShare = 0.5;  // of the points
    std::vector<Vec3> high;
    for (const Vec3& p : points_)
      if ((p.head<2>() - in_.centre).norm() <= in_.radius && result_.ground.height_above(p) > options_.min_height_m)
        high.push_back(p);
    const geometry::KdTree tree(high);
    const std::size_t stride = std::max<std::size_t>(1, high.size() / kSample);
    std::size_t asked = 0, thick = 0;
    for (std::size_t i = 0; i < high.size(); i += stride, ++asked) {
      // Wide enough that noise across the skin does not count.
      const double reach = 5.0 * result_.spacing;
      auto near = tree.within(high[i], reach);
      if (near.size() < kNeighbours) near = tree.nearest(high[i], kNeighbours);
      Vec3 mean = Vec3::Zero();
      for (const auto& q : near) mean += high[q.index] / static_cast<double>(near.size());
      geometry::Mat3 scatter = geometry::Mat3::Zero();
      for (const auto& q : near) scatter += (high[q.index] - mean) * (high[q.index] - mean).transpose();
      const Eigen::SelfAdjointEigenSolver<geometry::Mat3> solver(scatter, Eigen::EigenvaluesOnly);
      thick += solver.eigenvalues()[0] > kThick * scatter.trace();
    }
    thick_share_ = asked == 0 ? 0.0 : static_cast<double>(thick) / static_cast<double>(asked);
    if (thick_share_ <= kThickShare) return true;
    fail("not_a_surface", base::to_fixed(100.0 * thick_share_, 0) + " % of its points lie in a volume, not on a skin");
    return false;
  }

  void build() {
    double step = options_.step_spacings * result_.spacing;
    graph_ = build_patch_graph(points_, step);
    while (graph_.size() > static_cast<std::size_t>(options_.max_nodes)) {
      step *= 1.05 * std::sqrt(static_cast<double>(graph_.size()) / static_cast<double>(options_.max_nodes));
      graph_ = build_patch_graph(points_, step);
    }
    reach_ = std::max(options_.bend_reach_spacings * result_.spacing, 2.0 * step);
    const std::size_t n = graph_.size();
    height_.resize(n), off_axis_.resize(n), known_.assign(n, 0);
    for (std::size_t i = 0; i < n; ++i) {
      height_[i] = result_.ground.height_above(graph_.position[i]);
      off_axis_[i] = (graph_.position[i].head<2>() - in_.centre).norm();
    }
    others_.assign(n, std::numeric_limits<double>::infinity());
    for (const auto& other : in_.others)
      for (std::size_t i = 0; i < n; ++i)
        others_[i] = std::min(others_[i], (graph_.position[i].head<2>() - other.centre).norm() / other.radius);
    const geometry::KdTree tree(graph_.position);
    for (const auto& pick : in_.picks)
      for (const auto& near : tree.within(pick.position, 1.5 * graph_.step)) known_[near.index] = pick.rock ? 1 : 2;
  }

  [[nodiscard]] std::vector<CutEdge> weigh_pairs(const PatchGraph& graph) const {
    std::vector<CutEdge> edges;
    edges.reserve(graph.pairs.size());
    for (const auto& p : graph.pairs) {
      const double bend = 0.5 * (static_cast<double>(graph.concavity[p.a]) + static_cast<double>(graph.concavity[p.b]));
      const auto cost = static_cast<float>(std::exp(-std::max(0.0, bend) / options_.concavity_scale));
      const double length = (graph.position[p.a] - graph.position[p.b]).norm() / graph.step;
      edges.push_back({p.a, p.b, std::max(kLeastCapacity, cost) / static_cast<float>(std::max(length, 0.3))});
    }
    return edges;
  }

  // The cheapest cut between nodes that are rock (1) and nodes that are not (2); 0 = open.
  static std::vector<std::uint8_t> cheapest(const std::vector<CutEdge>& edges, const std::vector<std::uint8_t>& state) {
    const std::size_t n = state.size();
    std::vector<std::uint32_t> id(n, kNowhere);
    std::vector<float> source, sink;
    for (std::size_t i = 0; i < n; ++i)
      if (state[i] == 0) {
        id[i] = static_cast<std::uint32_t>(source.size());
        source.push_back(0.0F), sink.push_back(0.0F);
      }
    std::vector<CutEdge> open;
    for (const auto& e : edges) {
      if (id[e.a] != kNowhere && id[e.b] != kNowhere) {
        open.push_back({id[e.a], id[e.b], e.capacity});
      } else if (id[e.a] != kNowhere || id[e.b] != kNowhere) {
        const std::uint32_t inside = id[e.a] != kNowhere ? e.a : e.b, border = id[e.a] != kNowhere ? e.b : e.a;
        (state[border] == 1 ? source : sink)[id[inside]] += e.capacity;
      }
    }
    const auto side = minimum_cut(source.size(), open, source, sink);
    std::vector<std::uint8_t> rock(n);
    for (std::size_t i = 0; i < n; ++i) rock[i] = id[i] != kNowhere ? side[id[i]] : state[i] == 1 ? 1 : 0;
    return rock;
  }

  [[nodiscard]] Cut cut_between(const std::vector<std::uint8_t>& state) const {
    Cut cut;
    cut.rock = cheapest(edges_, state);
    double total = 0.0;
    for (const auto& e : edges_) {
      if (cut.rock[e.a] == cut.rock[e.b]) continue;
      const double w = graph_.step / std::max((graph_.position[e.a] - graph_.position[e.b]).norm(), 0.3 * graph_.step);
      total += w;
      cut.concavity +=
          w * 0.5 * (static_cast<double>(graph_.concavity[e.a]) + static_cast<double>(graph_.concavity[e.b]));
      cut.height += w * 0.5 * (height_[e.a] + height_[e.b]);
      cut.middle += w * 0.5 * (graph_.position[e.a] + graph_.position[e.b]).head<2>();
    }
    if (total > 0.0) {
      cut.any = true;
      cut.concavity /= total, cut.height /= total, cut.middle /= total;
    }
    return cut;
  }

  // How well a crease's height fits the lower end of the cylinder, 0..1; located cylinders reach a little below their
  // rock.
  [[nodiscard]] double likely(const Cut& cut) const {
    const double tall = in_.high - in_.low;
    if (!(tall > 0.0)) return 1.0;
    const double above = (result_.ground.up(cut.middle) + cut.height - in_.low) / tall;
    const double off = std::max({0.0, above - kHighFoot, kLowFoot - above});
    return std::exp(-off * off / (2.0 * kFootSpread * kFootSpread));
  }

  Cut best_cut(const Vec2& axis, double from = 0.1, double to = 0.9) {
    measure_concavity(graph_, axis, reach_);
    edges_ = weigh_pairs(graph_);
    const double inner = in_.radius + options_.margin_m;
    std::vector<Cut> cuts;
    for (double top = 0.85; top > 0.1; top -= kBandStep) {
      if (top < from || top > to) continue;
      const double upper = top * result_.height, lower = (top - kBandWidth) * result_.height;
      std::vector<std::uint8_t> state(graph_.size(), 0);
      for (std::size_t i = 0; i < state.size(); ++i) {
        if (known_[i] != 0) state[i] = known_[i];
        else if (off_axis_[i] > inner || height_[i] < lower || height_[i] < -foot_height_) state[i] = 2;
        else if (others_[i] < 0.5) state[i] = 2;
        else if (off_axis_[i] <= in_.radius && height_[i] > upper && others_[i] > off_axis_[i] / in_.radius)
          state[i] = 1;
      }
      Cut cut = cut_between(state);
      cut.top = top;
      if (cut.any) cuts.push_back(std::move(cut));
    }
    if (cuts.empty()) return {};
    const auto best = std::max_element(cuts.begin(), cuts.end(), [&](const Cut& a, const Cut& b) {
      return a.worth(foot_height_) * likely(a) < b.worth(foot_height_) * likely(b);
    });
    if (best->height < foot_height_) return std::move(*best);
    // A rock may have a waist of its own: of creases that are nearly as good the lowest one closes around its foot.
    auto lowest = best;
    for (auto cut = cuts.begin(); cut != cuts.end(); ++cut)
      if (cut->height >= foot_height_ && cut->height < lowest->height &&
          cut->concavity * likely(*cut) >= kNearlyAsGood * best->concavity * likely(*best))
        lowest = cut;
    return std::move(*lowest);
  }

  // What stands out of the ground below the rock.
  std::vector<std::uint8_t> find_pedestal() const {
    const double inner = in_.radius + options_.margin_m;
    std::vector<std::uint8_t> state(graph_.size(), 0);
    for (const auto& e : edges_)
      if (rock_[e.a] != rock_[e.b]) state[e.a] = state[e.b] = 1;
    for (std::size_t i = 0; i < state.size(); ++i)
      if (rock_[i] != 0) state[i] = 1;
      else if (off_axis_[i] > inner) state[i] = 2;
    Cut cut = cut_between(state);
    for (std::size_t i = 0; i < state.size(); ++i)
      if (rock_[i] != 0) cut.rock[i] = 0;
    return cut.rock;
  }

  // The points near the cut at twice the resolution.
  void refine(const Vec2& axis) {
    sides_.resize(points_.size());
    for (std::size_t i = 0; i < points_.size(); ++i)
      sides_[i] = rock_[graph_.node_of[i]] != 0 ? Side::rock : Side::other;
    const std::size_t n = graph_.size();
    std::vector<std::uint8_t> border(n, 0);
    std::vector<Vec3> places;
    for (const auto& e : edges_)
      if (rock_[e.a] != rock_[e.b])
        for (const auto i : {e.a, e.b})
          if (border[i] == 0) border[i] = 1, places.push_back(graph_.position[i]);
    if (places.empty()) return;
    const geometry::KdTree tree(places);
    const double free = 2.0 * graph_.step, outer = free + reach_ + graph_.step;
    std::vector<std::uint8_t> near(n, 0);
    for (std::size_t i = 0; i < n; ++i) {
      const double d = std::sqrt(tree.nearest(graph_.position[i], 1).front().squared_distance);
      near[i] = d <= free ? 2 : d <= outer ? 1 : 0;
    }
    std::vector<Vec3> points;
    std::vector<std::uint32_t> which;
    for (std::uint32_t i = 0; i < points_.size(); ++i)
      if (near[graph_.node_of[i]] != 0) points.push_back(points_[i]), which.push_back(i);
    PatchGraph fine = build_patch_graph(points, 0.5 * graph_.step);
    measure_concavity(fine, axis, std::max(0.75 * reach_, 2.0 * fine.step));
    std::vector<std::uint8_t> state(fine.size(), 0);
    for (std::size_t k = 0; k < which.size(); ++k) {
      const std::uint32_t coarse = graph_.node_of[which[k]];
      if (known_[coarse] != 0) state[fine.node_of[k]] = known_[coarse];
      else if (near[coarse] == 1) state[fine.node_of[k]] = rock_[coarse] != 0 ? 1 : 2;
    }
    const auto rock = cheapest(weigh_pairs(fine), state);
    for (std::size_t k = 0; k < which.size(); ++k)
      sides_[which[k]] = rock[fine.node_of[k]] != 0 ? Side::rock : Side::other;
  }

  void locate_contact() {
    if (in_.contact.empty()) {
      result_.line = fit_contact(points_, sides_, result_.spacing);
      result_.contact = result_.line.contact();
      result_.noise = result_.line.residual;
      const double seen = result_.line.observed_share();
      if (seen < 0.5) result_.notes.emplace_back("hidden_base");
    } else {
      result_.contact = in_.contact;
    }
    if (result_.concavity < 1.3 * options_.least_concavity) result_.notes.emplace_back("weak_contact");
  }

  void label_points() {
    std::vector<Vec3> vertices;
    for (const auto& v : result_.contact) vertices.push_back(v.position);
    const geometry::KdTree tree(vertices);
    const double spacing = result_.spacing;
    const double sure = 1.0 - 0.5 * std::exp(-result_.concavity / 0.03);
    for (std::size_t i = 0; i < points_.size(); ++i) {
      const std::uint32_t node = graph_.node_of[i];
      bool rock = sides_[i] == Side::rock;
      double distance = std::numeric_limits<double>::infinity(), sigma = spacing;
      if (!vertices.empty()) {
        const auto near = tree.nearest(points_[i], 1).front();
        distance = std::sqrt(near.squared_distance);
        sigma = std::hypot(spacing, result_.contact[near.index].sigma_m);
        if (!result_.line.profiles.empty() && distance < kRelabelSpacings * spacing) {
          const auto& profile = result_.line.profiles[near.index];
          const Vec3 d = points_[i] - profile.position;
          const Vec2 q(d.head<2>().dot(profile.outward), d.z());
          rock = q.dot(profile.flank) > q.dot(profile.seat);
        }
      }
      Label label = rock ? Label::rock : pedestal_[node] != 0 ? Label::pedestal : Label::terrain;
      // How sure the side is grows with the way to the line.
      double probability = sure * (0.5 + 0.5 * std::erf(distance / (1.5 * sigma)));
      if (distance <= kBasalSpacings * spacing) {
        label = Label::basal_contact;
        probability = sure * std::exp(-0.5 * distance * distance / (4.0 * sigma * sigma));
      }
      result_.labels[index_[i]] = label;
      result_.probability[index_[i]] = static_cast<float>(probability);
    }
  }

 private:
  const PatchInput& in_;
  const RockPatchOptions& options_;
  PatchResult& result_;
  std::vector<std::uint32_t> index_;  // of points_ in the input
  std::vector<Vec3> points_;
  std::size_t distinct_ = 0;
  double thick_share_ = 0.0;
  PatchGraph graph_;
  std::vector<double> height_, off_axis_;  // of the nodes: above the ground, from the cylinder's axis, m
  std::vector<double> others_;             // of the nodes: from the nearest other rock, over its radius
  std::vector<std::uint8_t> known_;        // picks: 1 rock, 2 not
  std::vector<CutEdge> edges_;
  std::vector<std::uint8_t> rock_, pedestal_;  // of the nodes
  std::vector<Side> sides_;                    // of the points
  double reach_ = 0.0;                         // over which a bend is felt, m
  double foot_height_ = 0.1;                   // creases below this height lie on the ground, m
};

}  // namespace

void RockPatchOptions::visit(base::OptionVisitor& visitor) {
  visitor.real("step-spacings", step_spacings, 1.0, 20.0, "working resolution over the spacing of the points");
  visitor.integer("max-nodes", max_nodes, 100, 10'000'000, "the working resolution is made coarser beyond");
  visitor.real("rock-margin-m", margin_m, 0.0, 10.0, "beyond the radius and this everything is no rock");
  visitor.real("rock-min-height-m", min_height_m, 0.0, 10.0, "what stands less above the ground is no rock");
  visitor.real("concavity-scale", concavity_scale, 0.001, 10.0, "bend at which the cost of a cut falls to 1/e");
  visitor.real("least-concavity", least_concavity, 0.0, 1.0, "mean bend along the contact, at least");
  visitor.integer("rock-min-points", min_points, 4, 1'000'000, "fewer points above the ground: rejected");
}

PatchResult segment_patch(const PatchInput& input, const RockPatchOptions& options) {
  PatchResult result;
  Patch patch(input, options, result);
  patch.run();
  return result;
}

}  // namespace cairn::segmentation
