#include "rock_run.hpp"

#include <unistd.h>

#include <cmath>
#include <ctime>
#include <functional>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "base/random.hpp"
#include "io/cloud.hpp"
#include "io/contact_csv.hpp"
#include "io/targets_json.hpp"
#include "io/truth.hpp"
#include "pipeline/evaluate_segmentation.hpp"
#include "pipeline/fragility_stage.hpp"
#include "pipeline/segment_stage.hpp"
#include "pipeline/surface_stage.hpp"

namespace cairn::acceptance {
namespace fs = std::filesystem;
namespace {

using geometry::Vec3;
using io::Json;

double cpu_seconds() {
  return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

// As `locate` gives it at close range: the axis off by a tenth of a metre, the radius too large.
void write_target(const fs::path& path, const testing::RockScan& scan) {
  base::Random random(scan.seed, "rock run target", 0);
  io::TargetsFile file;
  survey::Target target;
  target.id = survey::TargetId(1);
  target.object_class = "rock";
  target.state = survey::TargetState::converged;
  auto cylinder = scan.cylinder;
  cylinder.axis += 0.08 * geometry::Vec2(random.normal(), random.normal());
  cylinder.radius *= random.uniform(1.0, 1.25);
  cylinder.top += random.uniform(-0.05, 0.1);
  cylinder.bottom -= random.uniform(0.0, 0.3);
  target.centre = cylinder.centre();
  target.bcylinder = cylinder;
  file.targets.push_back(target);
  io::write_targets(path, file);
}

// The true cylinders as targets.
void write_targets_of(const fs::path& path, const survey::Truth& truth) {
  io::TargetsFile file;
  for (const auto& object : truth.objects) {
    survey::Target target;
    target.id = survey::TargetId(object.id.value);
    target.object_class = "rock";
    target.state = survey::TargetState::converged;
    target.centre = object.cylinder.centre();
    target.bcylinder = object.cylinder;
    file.targets.push_back(std::move(target));
  }
  io::write_targets(path, file);
}

void write_truth_files(const fs::path& folder, const geometry::PointCloud& labelled, const survey::Truth& truth) {
  io::write_cloud(folder / "truth.las", labelled);
  fs::create_directories(folder / "truth");
  io::write_truth(truth, survey::Origin{}, folder / "truth");
}

void write_true_labels(const fs::path& folder, const testing::RockScan& scan) {
  io::write_cloud(folder / "labelled.las", scan.labelled());
  io::ContactFile contact;
  contact.crs = "local";
  for (const auto& vertex : scan.contact()) contact.rows.push_back({1, vertex});
  io::write_contact_csv(folder / "labelled.contact.csv", contact);
}

// Runs a step and notes its time; false where it failed.
bool step(Json& line, const std::string& name, const std::function<void()>& run) {
  const double before = cpu_seconds();
  std::string failed;
  try {
    run();
  } catch (const std::exception& error) {
    failed = name + ": " + error.what();
  }
  Json cpu = line.find("cpu_s") != nullptr ? line.at("cpu_s") : Json::object();
  cpu.set(name, std::round(1e3 * (cpu_seconds() - before)) / 1e3);
  line.set("cpu_s", std::move(cpu));
  if (!failed.empty()) line.set("failed", failed);
  return failed.empty();
}

void note_rejects(Json& line, const std::string& name, const pipeline::Outcome& outcome) {
  for (const auto& reject : outcome.rejects)
    if (line.at("failed").as_string().empty()) line.set("failed", name + ": " + reject.reason);
}

// Surface and fragility of labelled.las.
bool measure(Json& line, const fs::path& folder, base::RunContext& ctx) {
  fs::create_directories(folder / "surface");
  fs::create_directories(folder / "fragility");
  bool good = step(line, "surface", [&] {
    note_rejects(line, "surface", pipeline::surface_file({folder / "labelled.las", {}}, folder / "surface", {}, ctx));
  });
  good = good && step(line, "fragility", [&] {
           pipeline::FragilityFiles in;
           in.input = folder / "surface";
           fragility::FragilityOptions how;
           note_rejects(line, "fragility", pipeline::fragility_files(in, folder / "fragility", true, how, ctx));
         });
  return good;
}

void score(Json& line, const fs::path& folder, const fs::path& rocks, base::RunContext& ctx) {
  pipeline::EvaluateSegmentationInputs in;
  in.labelled = folder / "labelled.las";
  in.truth = folder / "truth.las";
  in.truth_rocks = folder / "truth";
  in.rocks = rocks;
  step(line, "evaluate", [&] { line.set("scores", pipeline::evaluate_segmentation(in, {}, ctx).summary); });
}

// Where the files of a run stand: kept, or gone with this object.
class RunFolder {
 public:
  RunFolder(const fs::path& keep, const std::string& name)
      : staged_(keep.empty() ? fs::temp_directory_path() / ("cairn_acceptance_" + std::to_string(::getpid()) + name)
                             : keep / name,
                true),
        keep_(!keep.empty()) {}
  ~RunFolder() {
    if (keep_) staged_.commit();
  }
  RunFolder(const RunFolder&) = delete;
  RunFolder& operator=(const RunFolder&) = delete;
  [[nodiscard]] const fs::path& path() const { return staged_.path(); }

 private:
  base::StagedFolder staged_;
  bool keep_;
};

}  // namespace

Json run_rock(std::uint64_t seed, const RockRunOptions& options, base::RunContext& ctx) {
  const auto scan = testing::make_rock_scan(seed, options.scan);
  const char* hidings[] = {"drawn", "none", "brush", "sector", "absent"};
  Json line = Json::object({{"kind", "rock"},
                            {"seed", static_cast<std::int64_t>(seed)},
                            {"sampling", static_cast<std::int64_t>(options.scan.sampling)},
                            {"family", scan.family},
                            {"hiding", hidings[static_cast<std::size_t>(scan.hiding)]},
                            {"hidden_share", scan.hidden_share},
                            {"points", scan.cloud.size()},
                            {"spacing_m", scan.spacing_m},
                            {"failed", ""}});
  const RunFolder run(options.keep, "rock_" + std::to_string(seed) + "_" + std::to_string(options.scan.sampling));
  const fs::path& folder = run.path();
  io::write_cloud(folder / "cloud.las", scan.cloud);
  write_truth_files(folder, scan.labelled(), scan.truth());
  write_target(folder / "targets.json", scan);
  bool good = true;
  if (options.true_labels) write_true_labels(folder, scan);
  else
    good = step(line, "segment", [&] {
      pipeline::SegmentFiles in;
      in.cloud = folder / "cloud.las";
      if (options.guided) in.targets = folder / "targets.json";
      note_rejects(line, "segment",
                   pipeline::segment_file(in, folder / "labelled.las", folder / "labelled.contact.csv", {}, ctx));
    });
  if (!good) return line;
  good = measure(line, folder, ctx);
  score(line, folder, good ? folder / "fragility" : fs::path(), ctx);
  return line;
}

Json run_scene(std::uint64_t seed, const testing::RockSceneOptions& options, const fs::path& keep,
               base::RunContext& ctx) {
  const auto scene = testing::make_rock_scene(seed, options);
  Json line = Json::object({{"kind", "scene"},
                            {"seed", static_cast<std::int64_t>(seed)},
                            {"family", options.family},
                            {"points", scene.cloud.size()},
                            {"rocks", scene.rocks.size()},
                            {"failed", ""}});
  const RunFolder run(keep, "scene_" + std::to_string(seed));
  const fs::path& folder = run.path();
  io::write_cloud(folder / "cloud.las", scene.cloud);
  survey::Truth truth;
  truth.scene = "rock scene";
  truth.seed = seed;
  io::write_cloud(folder / "truth.las", scene.labelled());
  const bool good = step(line, "segment", [&] {
    pipeline::SegmentFiles in;
    in.cloud = folder / "cloud.las";
    (void)pipeline::segment_file(in, folder / "labelled.las", folder / "labelled.contact.csv", {}, ctx);
  });
  if (!good) return line;
  pipeline::EvaluateSegmentationInputs in;
  in.labelled = folder / "labelled.las";
  in.truth = folder / "truth.las";
  step(line, "evaluate", [&] { line.set("scores", pipeline::evaluate_segmentation(in, {}, ctx).summary); });
  return line;
}

Json run_cloud(const fs::path& cloud, const fs::path& truth, const fs::path& keep, base::RunContext& ctx) {
  Json line = Json::object({{"kind", "cloud"}, {"seed", 0}, {"family", ""}, {"failed", ""}});
  const RunFolder run(keep, "cloud_" + cloud.stem().string());
  const fs::path& folder = run.path();
  bool good = step(line, "segment", [&] {
    pipeline::SegmentFiles in;
    in.cloud = cloud;
    if (!truth.empty()) {
      write_targets_of(folder / "targets.json", io::read_truth(truth));
      in.targets = folder / "targets.json";
    }
    (void)pipeline::segment_file(in, folder / "labelled.las", folder / "labelled.contact.csv", {}, ctx);
  });
  good = good && measure(line, folder, ctx);
  if (!good || truth.empty()) return line;
  pipeline::EvaluateSegmentationInputs in;
  in.labelled = folder / "labelled.las";
  in.truth = cloud;
  in.truth_rocks = truth;
  in.rocks = folder / "fragility";
  step(line, "evaluate", [&] { line.set("scores", pipeline::evaluate_segmentation(in, {}, ctx).summary); });
  return line;
}

}  // namespace cairn::acceptance
