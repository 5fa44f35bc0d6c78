#include "geometry/point_cloud.hpp"

#include <utility>

namespace cairn::geometry {
namespace {

template <typename T>
std::vector<T> pick(const std::vector<T>& column, const std::vector<std::size_t>& indices) {
  std::vector<T> picked;
  if (column.empty()) return picked;
  picked.reserve(indices.size());
  for (const std::size_t i : indices) picked.push_back(column[i]);
  return picked;
}

}  // namespace

const ScalarColumn* PointCloud::scalar(const std::string& name) const {
  for (const auto& column : scalars)
    if (column.name == name) return &column;
  return nullptr;
}

ScalarColumn& PointCloud::add_scalar(std::string name, ScalarType type, std::string description) {
  for (auto& column : scalars)
    if (column.name == name) {
      column = {std::move(name), type, std::move(description), std::vector<double>(size(), 0.0)};
      return column;
    }
  return scalars.emplace_back(
      ScalarColumn{std::move(name), type, std::move(description), std::vector<double>(size(), 0.0)});
}

bool PointCloud::consistent() const {
  const auto fits = [this](std::size_t n) { return n == 0 || n == size(); };
  for (const auto& column : scalars)
    if (column.values.size() != size()) return false;
  return fits(colours.size()) && fits(normals.size()) && fits(intensity.size()) && fits(classification.size()) &&
         fits(gps_time.size());
}

PointCloud PointCloud::subset(const std::vector<std::size_t>& indices) const {
  PointCloud part;
  part.positions = pick(positions, indices);
  part.colours = pick(colours, indices);
  part.normals = pick(normals, indices);
  part.intensity = pick(intensity, indices);
  part.classification = pick(classification, indices);
  part.gps_time = pick(gps_time, indices);
  for (const auto& column : scalars)
    part.scalars.push_back({column.name, column.type, column.description, pick(column.values, indices)});
  return part;
}

}  // namespace cairn::geometry
