#include "pipeline/ground_figures.hpp"

#include <algorithm>
#include <limits>
#include <vector>

#include "base/number_text.hpp"
#include "report/drive_figure.hpp"

namespace cairn::pipeline {
namespace {

using geometry::Vec2;

std::vector<Vec2> places(const std::vector<survey::VehicleState>& states) {
  std::vector<Vec2> result;
  result.reserve(states.size());
  for (const auto& state : states) result.push_back(state.position);
  return result;
}

}  // namespace

std::string drive_svg(const simulation::DriveRehearsal& rehearsal, const GroundRecord& record, std::size_t index,
                      const std::string& title) {
  report::DriveFigure figure;
  figure.title = title;
  const auto& drive = rehearsal.drive();
  const bool whole = index >= record.snapshots.size();
  if (!whole) figure.cost = record.snapshots[index].cost;
  figure.min = figure.max = drive.area.front();
  for (const Vec2& p : drive.area) {
    figure.min = figure.min.cwiseMin(p);
    figure.max = figure.max.cwiseMax(p);
  }
  if (whole)
    for (const auto& ring : drive.prior_blocked) figure.outlines.push_back({ring, "#d8d8d8", "#bbb"});
  const auto& objects = rehearsal.flown().objects();
  for (std::size_t i = 0; i < objects.size(); ++i) {
    const auto& ring = rehearsal.contact().outlines()[i];
    if (ring.empty()) continue;
    const std::string& name = objects[i].truth.object_class;
    const std::string colour = name == "cone"   ? "#d55e00"
                               : name == "bush" ? "#009e73"
                               : name == "tree" ? "#6b4f1d"
                                                : "#56b4e9";
    figure.outlines.push_back({ring, whole ? colour : "none", colour});
  }
  const std::int64_t until = whole ? std::numeric_limits<std::int64_t>::max() : record.snapshots[index].time_ns;
  const GroundPlan* plan = nullptr;
  for (const auto& p : record.plans)
    if (p.time_ns <= until) plan = whole && plan != nullptr ? plan : &p;
  if (plan != nullptr)
    figure.tracks.push_back({whole ? "first plan" : "plan that is followed", "#cc79a7", true, plan->path});
  const auto driven = [&](const std::vector<survey::VehicleState>& states) {
    auto all = places(states);
    const auto count = std::count_if(states.begin(), states.end(), [&](const auto& s) { return s.time_ns <= until; });
    all.resize(static_cast<std::size_t>(count));
    return all;
  };
  if (whole) figure.tracks.push_back({"inertial log alone", "#999999", false, driven(record.inertial)});
  figure.tracks.push_back({"filtered", "#e69f00", false, driven(record.filtered)});
  figure.tracks.push_back(
      {"true way, " + base::to_fixed(record.path_m, 1) + " m in all", "#0072b2", false, driven(record.truth)});
  figure.marks = {{drive.start, "start"}, {drive.goal, "goal"}};
  return report::drive_figure_svg(figure);
}

}  // namespace cairn::pipeline
