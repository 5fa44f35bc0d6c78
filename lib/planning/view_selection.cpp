#include "planning/view_selection.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <queue>

#include "base/angle.hpp"
#include "base/parallel.hpp"
#include "camera/projection.hpp"

namespace cairn::planning {
namespace {

using geometry::Vec3;

// What has been seen of one demand.
struct State {
  std::uint32_t views = 0, steep = 0;
  bool fine = false, wide = false;  // wide: two sight lines at least the least parallax apart
  std::uint64_t cells = 0;          // of direction
  std::vector<Vec3> directions;     // until they are wide
};

constexpr int kAzimuthCells = 12, kElevationCells = 4;

std::uint64_t direction_cell(const Vec3& d) {
  double azimuth = std::atan2(d.x(), d.y()) / (2.0 * std::numbers::pi);
  if (azimuth < 0.0) azimuth += 1.0;
  const double elevation = std::asin(std::clamp(d.z(), 0.0, 1.0)) / (0.5 * std::numbers::pi);
  const int a = std::min(kAzimuthCells - 1, static_cast<int>(azimuth * kAzimuthCells));
  const int e = std::min(kElevationCells - 1, static_cast<int>(elevation * kElevationCells));
  return std::uint64_t{1} << static_cast<unsigned>(e * kAzimuthCells + a);
}

class Chooser {
 public:
  Chooser(std::span<const Demand> demands, const ViewGates& gates)
      : demands_(demands),
        least_views_(static_cast<std::uint32_t>(gates.min_views)),
        least_steep_(gates.min_views > 1 ? 2U : 1U),
        parallax_(gates.min_parallax_deg),
        states_(demands.size()) {
    for (std::size_t i = 0; i < demands.size(); ++i) {
      states_[i].fine = demands[i].max_gsd_m <= 0.0;
      states_[i].wide = parallax_ <= 0.0;
      if (demands[i].group >= total_.size()) total_.resize(demands[i].group + 1, 0.0);
      total_[demands[i].group] += demands[i].area_m2;
    }
    passing_.assign(total_.size(), 0.0);
    done_.assign(total_.size(), 0);
    for (std::size_t i = 0; i < demands.size(); ++i)
      if (passes(states_[i])) passing_[demands[i].group] += demands[i].area_m2;
  }

  // Share of each group's area that passes.
  [[nodiscard]] std::vector<double> shares() const {
    std::vector<double> result;
    for (std::size_t g = 0; g < total_.size(); ++g) result.push_back(total_[g] > 0.0 ? passing_[g] / total_[g] : 1.0);
    return result;
  }
  // Notes which groups have what they need; true where all have.
  bool settle(const std::vector<double>& wanted) {
    const auto now = shares();
    bool all = true;
    for (std::size_t g = 0; g < now.size(); ++g) {
      done_[g] = now[g] >= wanted[g] ? 1 : 0;
      all = all && done_[g] != 0;
    }
    return all;
  }

  [[nodiscard]] double gain(const std::vector<Sight>& sights) const {
    double sum = 0.0;
    for (const Sight& s : sights) {
      if (done_[demands_[s.demand].group] != 0) continue;
      const State& state = states_[s.demand];
      double parts = 0.0;
      if (state.views < least_views_) parts += 1.0 / least_views_;
      if (s.steep_enough && state.steep < least_steep_) parts += 1.0 / least_steep_;
      if (s.fine_enough && !state.fine) parts += 1.0;
      if (parallax_ > 0.0 && std::popcount(state.cells) < 2 &&
          (state.cells &
           direction_cell(Vec3(static_cast<double>(s.x), static_cast<double>(s.y), static_cast<double>(s.z)))) == 0)
        parts += 0.5;
      sum += worth(s.demand) * parts;
    }
    return sum;
  }

  void take(const std::vector<Sight>& sights) {
    for (const Sight& s : sights) {
      State& state = states_[s.demand];
      const bool before = passes(state);
      const Vec3 d(static_cast<double>(s.x), static_cast<double>(s.y), static_cast<double>(s.z));
      ++state.views;
      state.steep += s.steep_enough ? 1 : 0;
      state.fine = state.fine || s.fine_enough;
      state.cells |= direction_cell(d);
      if (!state.wide) {
        for (const Vec3& other : state.directions)
          if (2.0 * std::asin(std::min(1.0, 0.5 * (d - other).norm())) >= base::deg_to_rad(parallax_))
            state.wide = true;
        state.directions.push_back(d);
      }
      if (!before && passes(state)) passing_[demands_[s.demand].group] += demands_[s.demand].area_m2;
    }
  }

 private:
  [[nodiscard]] double worth(std::size_t i) const { return demands_[i].weight * demands_[i].area_m2; }
  [[nodiscard]] bool passes(const State& s) const {
    return s.views >= least_views_ && s.steep >= least_steep_ && s.fine && s.wide;
  }

  std::span<const Demand> demands_;
  std::uint32_t least_views_, least_steep_;
  double parallax_;
  std::vector<State> states_;
  std::vector<double> total_, passing_;  // area by group, m^2
  std::vector<std::uint8_t> done_;
};

}  // namespace

std::vector<std::vector<Sight>> sights(std::span<const survey::Frame> views, const survey::Camera& camera,
                                       std::span<const Demand> demands, const visibility::Scene& scene,
                                       const ViewGates& gates, double max_range, double frame_margin, double end_gap) {
  std::vector<std::vector<Sight>> all(views.size());
  const double steepest = std::cos(base::deg_to_rad(gates.max_incidence_deg));
  std::vector<std::uint32_t> by_east(demands.size());
  std::iota(by_east.begin(), by_east.end(), 0U);
  std::stable_sort(by_east.begin(), by_east.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return demands[a].centre.x() < demands[b].centre.x(); });
  base::parallel_for(views.size(), 16, [&](std::size_t begin, std::size_t end) {
    std::vector<Vec3> targets;
    std::vector<std::uint8_t> blocked;
    for (std::size_t v = begin; v < end; ++v) {
      std::vector<Sight>& seen = all[v];
      const auto T_camera_world = views[v].T_world_camera.inverse();
      const Vec3 eye = views[v].T_world_camera.translation;
      targets.clear();
      auto next = std::lower_bound(by_east.begin(), by_east.end(), eye.x() - max_range,
                                   [&](std::uint32_t i, double east) { return demands[i].centre.x() < east; });
      for (; next != by_east.end() && demands[*next].centre.x() <= eye.x() + max_range; ++next) {
        const Demand& demand = demands[*next];
        const Vec3 d = eye - demand.centre;
        const double squared = d.squaredNorm();
        const double facing = demand.normal.dot(d);
        if (facing <= 0.0 || squared > max_range * max_range) continue;
        const Vec3 p = T_camera_world * demand.centre;
        const auto pixel = camera::project(camera, p);
        if (!pixel || !camera::inside_image(camera, *pixel, frame_margin)) continue;
        const double range = std::sqrt(squared), cosine = facing / range;
        const double gsd = std::sqrt(p.z() * p.z() * p.z() / (range * camera.fx_px * camera.fy_px * cosine));
        const Vec3 unit = d / range;
        seen.push_back({*next, static_cast<float>(unit.x()), static_cast<float>(unit.y()), static_cast<float>(unit.z()),
                        cosine >= steepest, demand.max_gsd_m <= 0.0 || gsd <= demand.max_gsd_m});
        targets.push_back(demand.centre);
      }
      blocked.assign(targets.size(), 0);
      scene.blocked_from(eye, targets, blocked, end_gap);
      std::size_t kept = 0;
      for (std::size_t i = 0; i < seen.size(); ++i)
        if (blocked[i] == 0) seen[kept++] = seen[i];
      seen.resize(kept);
    }
  });
  return all;
}

Selection select_views(std::span<const Demand> demands, const ViewGates& gates,
                       std::span<const std::vector<Sight>> already, std::span<const std::vector<Sight>> candidates,
                       const SelectionOptions& options) {
  Selection result;
  Chooser chooser(demands, gates);
  for (const auto& view : already) chooser.take(view);
  const auto least = [](const std::vector<double>& shares) {
    return shares.empty() ? 1.0 : *std::min_element(shares.begin(), shares.end());
  };
  result.group_before = chooser.shares();
  result.share_before = least(result.group_before);
  {
    Chooser with_all = chooser;
    for (const auto& view : candidates) with_all.take(view);
    result.group_reachable = with_all.shares();
    result.share_reachable = least(result.group_reachable);
  }
  // What is reachable is compared with sums taken in another order.
  constexpr double kRounding = 1e-9;
  std::vector<double> wanted;
  for (const double share : result.group_reachable) wanted.push_back(std::min(options.target, share - kRounding));
  bool settled = chooser.settle(wanted);
  constexpr double kNothing = 1e-12;

  struct Entry {
    double gain;
    std::size_t candidate;
    std::size_t round;  // when the gain was computed
    bool operator<(const Entry& other) const {
      return gain != other.gain ? gain < other.gain : candidate > other.candidate;
    }
  };
  std::priority_queue<Entry> queue;
  std::vector<double> gains(candidates.size());
  std::vector<std::uint8_t> used(candidates.size(), 0);
  const auto evaluate_all = [&] {
    base::parallel_for(candidates.size(), 64, [&](std::size_t begin, std::size_t end) {
      for (std::size_t c = begin; c < end; ++c) gains[c] = used[c] != 0 ? 0.0 : chooser.gain(candidates[c]);
    });
    result.evaluations += candidates.size();
  };
  evaluate_all();
  if (options.lazy)
    for (std::size_t c = 0; c < candidates.size(); ++c) queue.push({gains[c], c, 0});

  while (!settled && result.chosen.size() < options.max_views) {
    const std::size_t round = result.chosen.size();
    std::size_t best = candidates.size();
    if (!options.lazy) {
      if (round > 0) evaluate_all();
      for (std::size_t c = 0; c < candidates.size(); ++c)
        if (used[c] == 0 && gains[c] > kNothing && (best == candidates.size() || gains[c] > gains[best])) best = c;
    } else {
      while (!queue.empty()) {
        Entry top = queue.top();
        queue.pop();
        if (top.gain <= kNothing) break;
        if (top.round == round) {
          best = top.candidate;
          break;
        }
        queue.push({chooser.gain(candidates[top.candidate]), top.candidate, round});
        ++result.evaluations;
      }
    }
    if (best == candidates.size()) break;
    used[best] = 1;
    chooser.take(candidates[best]);
    result.chosen.push_back(best);
    result.share.push_back(least(chooser.shares()));
    settled = chooser.settle(wanted);
  }
  result.group_after = chooser.shares();
  return result;
}

std::vector<std::size_t> short_tour(std::span<const Vec3> places, const Vec3& start) {
  std::vector<std::size_t> left(places.size()), tour;
  std::iota(left.begin(), left.end(), std::size_t{0});
  Vec3 at = start;
  while (!left.empty()) {
    const auto next = std::min_element(left.begin(), left.end(), [&](std::size_t a, std::size_t b) {
      const double da = (places[a] - at).squaredNorm(), db = (places[b] - at).squaredNorm();
      return da != db ? da < db : a < b;
    });
    tour.push_back(*next);
    at = places[*next];
    left.erase(next);
  }
  const auto place = [&](std::size_t i) -> const Vec3& { return i == 0 ? start : places[tour[i - 1]]; };
  const std::size_t n = tour.size();
  bool better = true;
  for (int round = 0; better && round < 50; ++round) {
    better = false;
    for (std::size_t i = 1; i < n; ++i)
      for (std::size_t j = i + 1; j <= n; ++j) {
        // Reverse the stretch i..j; after the last there is no way to save.
        const double old_way = (place(i) - place(i - 1)).norm() + (j < n ? (place(j + 1) - place(j)).norm() : 0.0);
        const double new_way = (place(j) - place(i - 1)).norm() + (j < n ? (place(j + 1) - place(i)).norm() : 0.0);
        if (new_way >= old_way - 1e-9) continue;
        std::reverse(tour.begin() + static_cast<std::ptrdiff_t>(i) - 1, tour.begin() + static_cast<std::ptrdiff_t>(j));
        better = true;
      }
  }
  return tour;
}

}  // namespace cairn::planning
