#include "pipeline/review_points.hpp"

#include <algorithm>

#include "base/error.hpp"
#include "segmentation/labels.hpp"

namespace cairn::pipeline {
namespace {

using base::Error;
using base::ErrorCode;
using segmentation::Label;

geometry::ScalarColumn& column(geometry::PointCloud& cloud, const char* name) {
  for (auto& scalar : cloud.scalars)
    if (scalar.name == name) return scalar;
  throw Error(ErrorCode::failed_precondition, "the labelled cloud has no column '" + std::string(name) + "'")
      .hint("Make it with cairn segment");
}

Error refuse(const std::filesystem::path& file, const PointChange& change, std::string message) {
  return Error(ErrorCode::invalid_input, std::move(message))
      .file(file.string())
      .record("line " + std::to_string(change.line) + ", rock " + std::to_string(change.rock));
}

}  // namespace

std::map<std::int64_t, std::size_t> change_points(geometry::PointCloud& labelled, const ReviewPlan& plan,
                                                  const std::filesystem::path& edits_file) {
  auto& target = column(labelled, segmentation::kTargetIdColumn).values;
  const auto& label = column(labelled, segmentation::kLabelColumn).values;
  const auto is_rock = [&](std::size_t i) { return label[i] == static_cast<double>(Label::rock); };
  for (const auto& change : plan.changes) {
    const auto from = static_cast<double>(change.merged >= 0 ? change.merged : change.rock);
    std::vector<std::size_t> counts(std::max<std::size_t>(1, change.parts.size()), 0);
    for (std::size_t i = 0; i < labelled.size(); ++i) {
      if (target[i] != from) continue;
      std::size_t part = 0;
      if (change.merged >= 0) {
        target[i] = static_cast<double>(change.rock);
      } else {
        double best = 0.0;
        for (std::size_t s = 0; s < change.seeds.size(); ++s) {
          const geometry::Vec3 d = labelled.positions[i] - change.seeds[s];
          const double away = change.seeds_have_height ? d.squaredNorm() : d.head<2>().squaredNorm();
          if (s == 0 || away < best) {
            best = away;
            part = s;
          }
        }
        target[i] = static_cast<double>(change.parts[part]);
      }
      if (is_rock(i)) ++counts[part];
    }
    for (std::size_t s = 0; s < counts.size(); ++s) {
      if (counts[s] > 0) continue;
      if (change.merged >= 0)
        throw refuse(edits_file, change, "rock " + std::to_string(change.merged) + " has no labelled points to merge");
      throw refuse(edits_file, change, "seed " + std::to_string(s + 1) + " of the split gets no point of the rock")
          .allowed("seeds on the parts of the rock, in the local frame [m]");
    }
  }
  std::map<std::int64_t, std::size_t> points;
  for (const auto id : plan.reshaped) points[id] = 0;
  for (std::size_t i = 0; i < labelled.size(); ++i)
    if (is_rock(i))
      if (const auto it = points.find(static_cast<std::int64_t>(target[i])); it != points.end()) ++it->second;
  return points;
}

geometry::PointCloud only_rocks(geometry::PointCloud labelled, const std::set<std::int64_t>& rocks) {
  auto& target = column(labelled, segmentation::kTargetIdColumn).values;
  auto& label = column(labelled, segmentation::kLabelColumn).values;
  constexpr auto kNone = static_cast<double>(segmentation::kNoTarget);
  for (std::size_t i = 0; i < labelled.size(); ++i) {
    if (target[i] == kNone || rocks.contains(static_cast<std::int64_t>(target[i]))) continue;
    target[i] = kNone;
    if (label[i] != static_cast<double>(Label::terrain)) label[i] = static_cast<double>(Label::unlabelled);
  }
  return labelled;
}

}  // namespace cairn::pipeline
