#include "localisation/pool_pairs.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <queue>

namespace cairn::localisation {
namespace {

using geometry::Mat3;
using geometry::Vec3;

struct Extent {
  std::size_t box;
  double west, east, south, north;
};

struct Hypothesis {
  double support = 0.0;
  Meeting at;
  double size_m = 0.0;
  std::size_t first = 0, second = 0;  // boxes
  // Order of the queue: greatest support first, then the lower boxes.
  friend bool operator<(const Hypothesis& a, const Hypothesis& b) {
    if (a.support != b.support) return a.support < b.support;
    return std::pair(a.first, a.second) > std::pair(b.first, b.second);
  }
};

}  // namespace

BoxJudge::BoxJudge(const PreparedBoxes& prepared, const DepthPrior& depth, const LocateOptions& options)
    : prepared_(prepared), options_(options), bounded_(depth.source() != "default") {
  range_.reserve(prepared.boxes.size());
  for (const auto& box : prepared.boxes) range_.push_back(depth.range(box));
}

Sighting BoxJudge::sighting(std::size_t b) const {
  const Box& box = prepared_.boxes[b];
  return {&prepared_.frames[box.frame], box.centre_px, box.sigma_px, box.cut};
}

double BoxJudge::size(std::size_t b, const Vec3& point) const {
  const Box& box = prepared_.boxes[b];
  const View& view = prepared_.frames[box.frame].view;
  return box.diagonal_px() * std::max(0.0, view.to_camera(point).z()) / view.fx_px;
}

bool BoxJudge::like_size(double a, double b) const {
  return a <= b * options_.size_ratio && b <= a * options_.size_ratio;
}

bool BoxJudge::fits_size(std::size_t b, const Vec3& point, double size_m) const {
  const double seen = size(b, point);
  // Of a cut box we know only that the object is not smaller.
  return prepared_.boxes[b].cut ? seen <= size_m * options_.size_ratio : like_size(seen, size_m);
}

bool BoxJudge::in_depth_range(std::size_t b, const Vec3& point) const {
  const double depth = prepared_.frames[prepared_.boxes[b].frame].view.to_camera(point).z();
  if (!bounded_) return depth > 0.0;
  return depth >= range_[b].near_m && depth <= range_[b].far_m;
}

std::pair<Vec3, Vec3> BoxJudge::ends(std::size_t b) const {
  const Box& box = prepared_.boxes[b];
  const View& view = prepared_.frames[box.frame].view;
  const Vec3 direction = view.direction(box.centre_px);
  return {view.T_world_camera.translation + range_[b].near_m * direction,
          view.T_world_camera.translation + range_[b].far_m * direction};
}

bool BoxJudge::fit(Candidate& c) const {
  return adopt(c, triangulate(sightings(c), {.gate = options_.box_gate, .least = 2}));
}

bool BoxJudge::fit_from(const Vec3& start, Candidate& c) const {
  return adopt(c, triangulate_from(start, sightings(c), {.gate = options_.box_gate, .least = 2}));
}

std::vector<Sighting> BoxJudge::sightings(Candidate& c) const {
  std::sort(c.boxes.begin(), c.boxes.end());
  std::vector<Sighting> result;
  for (const std::size_t b : c.boxes) result.push_back(sighting(b));
  return result;
}

bool BoxJudge::adopt(Candidate& c, const std::optional<Triangulation>& fix) const {
  if (!fix) return false;
  std::vector<std::size_t> kept;
  std::vector<double> sizes;
  std::size_t in_range = 0;
  for (std::size_t i = 0; i < c.boxes.size(); ++i) {
    if (!fix->inlier[i]) continue;
    kept.push_back(c.boxes[i]);
    if (!prepared_.boxes[c.boxes[i]].cut) sizes.push_back(size(c.boxes[i], fix->centre));
    if (in_depth_range(c.boxes[i], fix->centre)) ++in_range;
  }
  if (2 * in_range <= kept.size()) return false;
  c.boxes = std::move(kept);
  c.fix = *fix;
  c.fix.inlier.assign(c.boxes.size(), true);
  std::nth_element(sizes.begin(), sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2), sizes.end());
  c.size_m = sizes[sizes.size() / 2];
  return true;
}

std::vector<std::size_t> frames_showing(const PreparedBoxes& prepared, const Candidate& c,
                                        const LocateOptions& options) {
  std::vector<std::size_t> result;
  for (std::size_t f = 0; f < prepared.frames.size(); ++f) {
    const FrameView& frame = prepared.frames[f];
    const auto pixel = frame.view.project(c.fix.centre);
    if (!pixel) continue;
    const double depth = frame.view.to_camera(c.fix.centre).z();
    const double half = 0.5 * c.size_m * frame.view.fx_px / depth + options.edge_margin_px;
    if (pixel->x() >= half && pixel->y() >= half && pixel->x() <= static_cast<double>(frame.camera->width_px) - half &&
        pixel->y() <= static_cast<double>(frame.camera->height_px) - half)
      result.push_back(f);
  }
  return result;
}

std::vector<Candidate> candidates_from_pool(const PreparedBoxes& prepared, const BoxJudge& judge,
                                            const std::vector<std::size_t>& pool, const LocateOptions& options) {
  // Sweep from west to east over the map extents of the rays.
  std::vector<Extent> extents;
  for (const std::size_t b : pool) {
    const auto [a, z] = judge.ends(b);
    const double slack = judge.size(b, z);
    extents.push_back({b, std::min(a.x(), z.x()) - slack, std::max(a.x(), z.x()) + slack,
                       std::min(a.y(), z.y()) - slack, std::max(a.y(), z.y()) + slack});
  }
  std::sort(extents.begin(), extents.end(),
            [](const Extent& a, const Extent& b) { return a.west != b.west ? a.west < b.west : a.box < b.box; });
  const double gate2 = options.box_gate * options.box_gate;

  std::map<std::size_t, std::vector<std::size_t>> near;  // of each box, the boxes its ray may meet
  std::priority_queue<Hypothesis> queue;
  const auto meet = [&](std::size_t i, std::size_t j) {
    const auto at = intersect(judge.sighting(i), judge.sighting(j));
    if (!at || !judge.in_depth_range(i, at->point) || !judge.in_depth_range(j, at->point)) return;
    const double si = judge.size(i, at->point), sj = judge.size(j, at->point);
    if (!judge.like_size(si, sj)) return;
    const auto di = squared_distance(judge.sighting(i), at->point, Mat3::Zero());
    const auto dj = squared_distance(judge.sighting(j), at->point, Mat3::Zero());
    if (!di || !dj || *di > gate2 || *dj > gate2) return;
    // 2 + pool size bounds the support, so that every hypothesis is scored once before it can win.
    queue.push({static_cast<double>(pool.size() + 2), *at, 0.5 * (si + sj), std::min(i, j), std::max(i, j)});
  };
  for (std::size_t i = 0; i < extents.size(); ++i)
    for (std::size_t j = i + 1; j < extents.size() && extents[j].west <= extents[i].east; ++j) {
      const Extent &a = extents[i], &b = extents[j];
      if (a.south > b.north || b.south > a.north) continue;
      const Box &box_a = prepared.boxes[a.box], &box_b = prepared.boxes[b.box];
      if (box_a.object_class != box_b.object_class) continue;
      if (box_a.frame == box_b.frame) continue;
      near[a.box].push_back(b.box);
      near[b.box].push_back(a.box);
      if (!box_a.cut && !box_b.cut) meet(a.box, b.box);
    }

  std::vector<bool> free(prepared.boxes.size(), false);
  for (const std::size_t b : pool) free[b] = true;
  // The free boxes that agree with a hypothesis, the nearest of each frame, and the point they make together.
  const auto elect = [&](const Hypothesis& h, double* support) -> std::optional<Candidate> {
    std::map<std::size_t, std::pair<double, std::size_t>> best;  // per frame
    const auto consider = [&](std::size_t b) {
      if (!free[b] || !judge.fits_size(b, h.at.point, h.size_m)) return;
      const bool own = b == h.first || b == h.second;
      const auto d2 = squared_distance(judge.sighting(b), h.at.point, own ? Mat3(Mat3::Zero()) : h.at.covariance);
      if (!d2 || *d2 > gate2) return;
      const std::pair<double, std::size_t> entry(own ? 0.0 : *d2, b);
      const auto [at, fresh] = best.try_emplace(prepared.boxes[b].frame, entry);
      if (!fresh) at->second = std::min(at->second, entry);
    };
    consider(h.first);
    for (const std::size_t b : near[h.first]) consider(b);
    Candidate c;
    c.object_class = prepared.boxes[h.first].object_class;
    for (const auto& [frame, entry] : best) c.boxes.push_back(entry.second);
    if (c.boxes.size() < 2 || !judge.fit_from(h.at.point, c)) return std::nullopt;
    *support = 0.0;
    for (const std::size_t b : c.boxes)
      if (const auto d2 = squared_distance(judge.sighting(b), c.fix.centre, Mat3::Zero()))
        *support += 1.0 - *d2 / gate2;
    return c;
  };

  // Support only falls as boxes are taken: a hypothesis whose score still stands when it reaches the top is the best.
  std::vector<Candidate> found;
  while (!queue.empty()) {
    Hypothesis h = queue.top();
    queue.pop();
    if (!free[h.first] || !free[h.second]) continue;
    double support = 0.0;
    auto c = elect(h, &support);
    if (!c) continue;
    if (support < h.support) {
      h.support = support;
      queue.push(h);
      continue;
    }
    for (const std::size_t b : c->boxes) free[b] = false;
    found.push_back(std::move(*c));
  }
  return found;
}

}  // namespace cairn::localisation
