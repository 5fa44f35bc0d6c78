#include "bench/ground_bench_pcl.hpp"

#include <pcl/point_types.h>
#include <pcl/segmentation/approximate_progressive_morphological_filter.h>
#include <pcl/segmentation/impl/approximate_progressive_morphological_filter.hpp>

namespace cairn::bench {

std::vector<std::uint8_t> pcl_objects(std::span<const geometry::Vec3> points, const PclGroundOptions& options) {
  auto cloud = pcl::make_shared<pcl::PointCloud<pcl::PointXYZ>>();
  cloud->reserve(points.size());
  for (const auto& p : points) {
    const Eigen::Vector3f q = (p - points.front()).cast<float>();
    cloud->emplace_back(q.x(), q.y(), q.z());
  }
  pcl::ApproximateProgressiveMorphologicalFilter<pcl::PointXYZ> filter;
  filter.setInputCloud(cloud);
  filter.setCellSize(options.cell);
  filter.setSlope(options.slope);
  filter.setInitialDistance(options.initial_distance);
  filter.setMaxDistance(options.max_distance);
  filter.setMaxWindowSize(options.max_window);
  filter.setBase(options.base);
  filter.setExponential(options.exponential);
  pcl::Indices ground;
  filter.extract(ground);
  std::vector<std::uint8_t> object(points.size(), 1);
  for (const auto i : ground) object[static_cast<std::size_t>(i)] = 0;
  return object;
}

}  // namespace cairn::bench
