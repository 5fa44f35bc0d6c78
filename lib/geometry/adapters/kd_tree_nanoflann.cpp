#include <algorithm>
#include <nanoflann.hpp>
#include <utility>

#include "geometry/kd_tree.hpp"

namespace cairn::geometry {
namespace {

struct Points {
  std::span<const Vec3> values;
  [[nodiscard]] std::size_t kdtree_get_point_count() const { return values.size(); }
  [[nodiscard]] double kdtree_get_pt(std::size_t i, std::size_t axis) const {
    return values[i][static_cast<Eigen::Index>(axis)];
  }
  template <typename Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};

using Tree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, Points>, Points, 3, std::size_t>;

void order(std::vector<KdTree::Neighbour>& found) {
  std::sort(found.begin(), found.end(), [](const auto& a, const auto& b) {
    return std::pair(a.squared_distance, a.index) < std::pair(b.squared_distance, b.index);
  });
}

}  // namespace

struct KdTree::Impl {
  Points points;
  Tree tree;
  explicit Impl(std::span<const Vec3> values)
      : points{values}, tree(3, points, nanoflann::KDTreeSingleIndexAdaptorParams(16)) {
    tree.buildIndex();
  }
};

KdTree::KdTree(std::span<const Vec3> points) : impl_(std::make_unique<Impl>(points)) {}
KdTree::~KdTree() = default;
KdTree::KdTree(KdTree&&) noexcept = default;
KdTree& KdTree::operator=(KdTree&&) noexcept = default;

std::vector<KdTree::Neighbour> KdTree::nearest(const Vec3& query, std::size_t k) const {
  const std::size_t wanted = std::min(k, impl_->points.values.size());
  if (wanted == 0) return {};
  std::vector<std::size_t> index(wanted);
  std::vector<double> distance(wanted);
  const std::size_t got = impl_->tree.knnSearch(query.data(), wanted, index.data(), distance.data());
  std::vector<Neighbour> found;
  for (std::size_t i = 0; i < got; ++i) found.push_back({index[i], distance[i]});
  order(found);
  return found;
}

std::vector<KdTree::Neighbour> KdTree::within(const Vec3& query, double radius) const {
  if (impl_->points.values.empty() || !(radius >= 0.0)) return {};
  std::vector<std::pair<std::size_t, double>> matches;
  impl_->tree.radiusSearch(query.data(), radius * radius, matches, nanoflann::SearchParams(32, 0.0F, false));
  std::vector<Neighbour> found;
  found.reserve(matches.size());
  for (const auto& [index, squared] : matches) found.push_back({index, squared});
  order(found);
  return found;
}

}  // namespace cairn::geometry
