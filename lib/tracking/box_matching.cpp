#include "tracking/box_matching.hpp"

#include <algorithm>
#include <limits>

#include "geometry/assignment.hpp"

namespace cairn::tracking {
namespace {

using geometry::PixelBox;

struct Edge {
  std::size_t detection, track;
  double iou;
};

// All pairs of one class with IoU > 0, by detection, then track.
std::vector<Edge> overlapping(std::span<const ClassedBox> detections, std::span<const ClassedBox> tracks) {
  std::vector<Edge> edges;
  for (std::size_t d = 0; d < detections.size(); ++d)
    for (std::size_t t = 0; t < tracks.size(); ++t) {
      if (detections[d].object_class != tracks[t].object_class) continue;
      const double iou = intersection_over_union(detections[d].box, tracks[t].box);
      if (iou > 0.0) edges.push_back({d, t, iou});
    }
  return edges;
}

// True where each detection and each track is in at most one of the pairs above the threshold, and there is one.
bool unambiguous(const std::vector<Edge>& edges, std::size_t detections, std::size_t tracks, double least_iou) {
  std::vector<char> detection_taken(detections, 0), track_taken(tracks, 0);
  bool any = false;
  for (const Edge& e : edges) {
    if (!(e.iou > least_iou)) continue;
    if (detection_taken[e.detection] != 0 || track_taken[e.track] != 0) return false;
    detection_taken[e.detection] = track_taken[e.track] = 1;
    any = true;
  }
  return any;
}

// Groups of detections (0..n-1) and tracks (n..n+m-1) joined by edges.
class Groups {
 public:
  explicit Groups(std::size_t count) : parent_(count) {
    for (std::size_t i = 0; i < count; ++i) parent_[i] = i;
  }
  std::size_t find(std::size_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void join(std::size_t a, std::size_t b) {
    a = find(a);
    b = find(b);
    parent_[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::vector<std::size_t> parent_;
};

void assign_group(std::span<const Edge> edges, double least_iou, std::vector<std::size_t>& match) {
  if (edges.size() == 1) {
    if (edges[0].iou >= least_iou) match[edges[0].detection] = edges[0].track;
    return;
  }
  std::vector<std::size_t> rows, columns;
  for (const Edge& e : edges) {
    rows.push_back(e.detection);
    columns.push_back(e.track);
  }
  for (auto* list : {&rows, &columns}) {
    std::sort(list->begin(), list->end());
    list->erase(std::unique(list->begin(), list->end()), list->end());
  }
  const auto place = [](const std::vector<std::size_t>& list, std::size_t value) {
    return static_cast<std::size_t>(std::lower_bound(list.begin(), list.end(), value) - list.begin());
  };
  std::vector<double> cost(rows.size() * columns.size(), 0.0);
  for (const Edge& e : edges) cost[place(rows, e.detection) * columns.size() + place(columns, e.track)] = -e.iou;
  const auto column_of = geometry::assign(cost, rows.size(), columns.size());
  for (std::size_t r = 0; r < rows.size(); ++r) {
    if (column_of[r] == geometry::kUnassigned) continue;
    const double iou = -cost[r * columns.size() + column_of[r]];
    if (iou > 0.0 && iou >= least_iou) match[rows[r]] = columns[column_of[r]];
  }
}

}  // namespace

double intersection_over_union(const PixelBox& a, const PixelBox& b) {
  const double w = std::max(0.0, std::min(a.xmax, b.xmax) - std::max(a.xmin, b.xmin));
  const double h = std::max(0.0, std::min(a.ymax, b.ymax) - std::max(a.ymin, b.ymin));
  const double shared = w * h;
  if (!(shared > 0.0)) return 0.0;
  return shared / (a.area() + b.area() - shared);
}

std::vector<std::size_t> match_boxes(std::span<const ClassedBox> detections, std::span<const ClassedBox> tracks,
                                     double least_iou) {
  std::vector<std::size_t> match(detections.size(), kNoMatch);
  std::vector<Edge> edges = overlapping(detections, tracks);
  if (edges.empty()) return match;
  if (unambiguous(edges, detections.size(), tracks.size(), least_iou)) {
    for (const Edge& e : edges)
      if (e.iou > least_iou) match[e.detection] = e.track;
    return match;
  }
  Groups groups(detections.size() + tracks.size());
  for (const Edge& e : edges) groups.join(e.detection, detections.size() + e.track);
  std::stable_sort(edges.begin(), edges.end(),
                   [&](const Edge& a, const Edge& b) { return groups.find(a.detection) < groups.find(b.detection); });
  for (std::size_t begin = 0; begin < edges.size();) {
    const std::size_t root = groups.find(edges[begin].detection);
    std::size_t end = begin;
    while (end < edges.size() && groups.find(edges[end].detection) == root) ++end;
    assign_group(std::span(edges).subspan(begin, end - begin), least_iou, match);
    begin = end;
  }
  return match;
}

}  // namespace cairn::tracking
