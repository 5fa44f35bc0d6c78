#include <pcl/point_types.h>
#include <pcl/search/kdtree.h>
#include <pcl/segmentation/extract_clusters.h>

#include <algorithm>

#include "segmentation/clusters.hpp"

namespace cairn::segmentation {

std::vector<std::vector<std::size_t>> euclidean_clusters(std::span<const geometry::Vec3> points, double tolerance) {
  if (points.empty()) return {};
  geometry::Vec3 mean = geometry::Vec3::Zero();
  for (const auto& p : points) mean += p;
  mean /= static_cast<double>(points.size());
  auto cloud = pcl::make_shared<pcl::PointCloud<pcl::PointXYZ>>();
  cloud->reserve(points.size());
  for (const auto& p : points) {
    const Eigen::Vector3f q = (p - mean).cast<float>();
    cloud->emplace_back(q.x(), q.y(), q.z());
  }
  auto tree = pcl::make_shared<pcl::search::KdTree<pcl::PointXYZ>>();
  tree->setInputCloud(cloud);
  pcl::EuclideanClusterExtraction<pcl::PointXYZ> extraction;
  extraction.setClusterTolerance(tolerance);
  extraction.setMinClusterSize(1U);
  extraction.setMaxClusterSize(static_cast<pcl::uindex_t>(points.size()));
  extraction.setSearchMethod(tree);
  extraction.setInputCloud(cloud);
  std::vector<pcl::PointIndices> found;
  extraction.extract(found);

  std::vector<std::vector<std::size_t>> clusters;
  for (const auto& group : found) {
    std::vector<std::size_t> cluster(group.indices.begin(), group.indices.end());
    std::sort(cluster.begin(), cluster.end());
    clusters.push_back(std::move(cluster));
  }
  std::sort(clusters.begin(), clusters.end(), [](const auto& a, const auto& b) {
    return a.size() != b.size() ? a.size() > b.size() : a.front() < b.front();
  });
  return clusters;
}

}  // namespace cairn::segmentation
