// A small result as `cairn run` leaves it, made by the stages themselves from a cloud whose labels are known.
#pragma once

#include <cmath>
#include <filesystem>
#include <string>

#include "base/atomic_file.hpp"
#include "base/random.hpp"
#include "base/run_context.hpp"
#include "io/cloud.hpp"
#include "io/json.hpp"
#include "io/survey_folder.hpp"
#include "io/targets_json.hpp"
#include "pipeline/stages.hpp"
#include "segmentation/labels.hpp"

namespace cairn::testing {

// Posts of 0.3 m radius and 1 m height on a lawn, 2 500 points each. Rock 1 stands alone; rocks 2 and 3 are the halves
// of one post at (4, 0); rock 4 is two posts, at (8, 0) and (9.2, 0); target 5 was not cut (too_few_points).
// `folder`/survey is the survey, `folder`/result the result.
inline void write_rock_result(const std::filesystem::path& folder) {
  namespace fs = std::filesystem;
  using segmentation::Label;
  const fs::path survey_folder = folder / "survey", result = folder / "result";
  fs::create_directories(survey_folder);
  fs::create_directories(result / ".cairn");
  survey::Survey survey;
  survey.manifest.name = "Two Posts";
  survey.manifest.origin = {{46.8426, -91.994, 158.0}, survey::HeightType::ellipsoidal, ""};
  io::write_survey(survey, survey_folder);

  base::Random random(7, "rock_result", 0);
  geometry::PointCloud cloud;
  auto label = std::vector<double>(), target = std::vector<double>();
  const auto add = [&](const geometry::Vec3& p, Label of, double id) {
    cloud.positions.push_back(p);
    label.push_back(static_cast<double>(of));
    target.push_back(id);
  };
  const geometry::Vec2 posts[4] = {{0, 0}, {4, 0}, {8, 0}, {9.2, 0}};
  for (int i = 0; i < 15000; ++i) {
    const geometry::Vec2 p(random.uniform(-2, 12), random.uniform(-2, 2));
    bool inside = false;
    for (const auto& c : posts) inside = inside || (p - c).norm() < 0.3;
    if (!inside) add({p.x(), p.y(), 0.0}, Label::terrain, double{segmentation::kNoTarget});
  }
  for (int k = 0; k < 4; ++k)
    for (int i = 0; i < 2500; ++i) {
      const double a = random.uniform(0, 6.283185307179586);
      const bool top = i >= 2150;
      const double r = top ? 0.3 * std::sqrt(random.uniform()) : 0.3, z = top ? 1.0 : random.uniform(0.0, 1.0);
      const geometry::Vec3 p(posts[k].x() + r * std::cos(a), posts[k].y() + r * std::sin(a), z);
      const double id = k == 0 ? 1 : k == 1 ? (p.z() < 0.5 ? 2 : 3) : 4;
      add(p, Label::rock, id);
    }
  cloud.add_scalar(segmentation::kLabelColumn, geometry::ScalarType::u8, "").values = label;
  cloud.add_scalar(segmentation::kTargetIdColumn, geometry::ScalarType::u32, "").values = target;
  io::write_cloud(result / "labelled.las", cloud);

  io::TargetsFile targets;
  targets.frame = survey.manifest.origin;
  io::Json segments = io::Json::array();
  const geometry::Vec3 centres[5] = {{0, 0, .5}, {4, 0, .25}, {4, 0, .75}, {8.6, 0, .5}, {2, 1.5, 0}};
  for (int k = 0; k < 5; ++k) {
    survey::Target t;
    t.id = survey::TargetId(k + 1);
    t.object_class = "boulder";
    t.state = survey::TargetState::mapped;
    t.centre = centres[k];
    t.covariance = geometry::Mat3::Identity() * 1e-4;
    targets.targets.push_back(t);
    const bool rejected = k == 4;
    segments.push(io::Json::object(
        {{"id", k + 1},
         {"class", "boulder"},
         {"rejected", rejected},
         {"reasons", io::Json(rejected ? std::vector<std::string>{"too_few_points"} : std::vector<std::string>{})},
         {"message", ""},
         {"point_count", rejected ? 0 : 2500},
         {"contact", io::Json::array()}}));
  }
  io::write_targets(result / "targets.json", targets);
  base::write_file(result / "segments.json",
                   io::Json::object({{"schema_version", 1}, {"segments", std::move(segments)}}).dump() + "\n");

  base::RunContext ctx;
  io::Json stages = io::Json::array();
  for (const char* name : {"surface", "fragility"}) {
    const auto stage = pipeline::make_stage(name);
    io::Json options = io::Json::object();
    if (std::string(name) == "fragility") {
      base::set_option(stage->options(), "draws", "0");
      options.set("draws", 0);
    }
    stage->run({survey_folder, result, {"locate", "segment", "surface"}}, result, ctx);
    stages.push(io::Json::object({{"stage", name}, {"options", std::move(options)}}));
  }
  const auto run = io::Json::object({{"cairn_version", "test"},
                                     {"command", "run"},
                                     {"arguments", io::Json::object({{"survey", survey_folder.string()}})},
                                     {"seed", 0},
                                     {"stages", std::move(stages)}});
  base::write_file(result / "run.json", run.dump() + "\n");
}

}  // namespace cairn::testing
