#include "pipeline/report_stage.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <set>
#include <string>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "base/version.hpp"
#include "camera/projection.hpp"
#include "io/json.hpp"
#include "io/obstacles_json.hpp"
#include "io/raster.hpp"
#include "io/survey_folder.hpp"
#include "io/targets_json.hpp"
#include "pipeline/report_parts.hpp"
#include "pipeline/run_record.hpp"

namespace cairn::pipeline {
namespace fs = std::filesystem;
namespace {

using base::Error;
using base::ErrorCode;

constexpr double kFootprintRange_m = 500.0;

bool counts(const ReportInputs& in, std::string_view stage) {
  return in.stages.empty() || std::find(in.stages.begin(), in.stages.end(), stage) != in.stages.end();
}

// First band as floats, integers' nodata as NaN.
geometry::Grid<float> float_band(const io::RasterBand& band) {
  return std::visit(
      [&](const auto& grid) {
        geometry::Grid<float> out(grid.geometry, 0.0F);
        for (std::size_t i = 0; i < grid.values.size(); ++i) {
          bool missing = false;
          if constexpr (std::is_integral_v<typename std::decay_t<decltype(grid.values)>::value_type>)
            missing = band.nodata && static_cast<std::int64_t>(grid.values[i]) == *band.nodata;
          out.values[i] = missing ? std::numeric_limits<float>::quiet_NaN() : static_cast<float>(grid.values[i]);
        }
        return out;
      },
      band.values);
}

std::optional<io::Raster> raster_of(const fs::path& file) {
  if (file.empty()) return std::nullopt;
  io::Raster raster = io::read_raster(file);
  if (raster.bands.empty()) return std::nullopt;
  return raster;
}

void add_raster(report::ReportData& data, const std::optional<io::Raster>& raster, report::RasterRole role,
                std::string unit) {
  if (raster) data.rasters.push_back({role, float_band(raster->bands.front()), std::move(unit)});
}

// The map shows ground that was measured: cells whose band `observed` is 0 become empty, but for
// single ones among measured neighbours.
void hide_interpolated(const io::Raster& surface, geometry::Grid<float>& heights) {
  constexpr int kNeighbours = 4;  // of eight
  const auto band =
      std::find_if(surface.bands.begin(), surface.bands.end(), [](const auto& b) { return b.name == "observed"; });
  if (band == surface.bands.end()) return;
  const geometry::Grid<float> observed = float_band(*band);
  if (observed.values.size() != heights.values.size()) return;
  const auto rows = static_cast<std::ptrdiff_t>(observed.geometry.rows);
  const auto columns = static_cast<std::ptrdiff_t>(observed.geometry.columns);
  const auto seen = [&](std::ptrdiff_t r, std::ptrdiff_t c) {
    return r >= 0 && c >= 0 && r < rows && c < columns &&
           observed.at(static_cast<std::size_t>(r), static_cast<std::size_t>(c)) > 0.0F;
  };
  for (std::ptrdiff_t r = 0; r < rows; ++r)
    for (std::ptrdiff_t c = 0; c < columns; ++c) {
      if (seen(r, c)) continue;
      int around = 0;
      for (std::ptrdiff_t y = r - 1; y <= r + 1; ++y)
        for (std::ptrdiff_t x = c - 1; x <= c + 1; ++x) around += seen(y, x) ? 1 : 0;
      if (around < kNeighbours)
        heights.at(static_cast<std::size_t>(r), static_cast<std::size_t>(c)) = std::numeric_limits<float>::quiet_NaN();
    }
}

void check_frame(const survey::Origin& product, const survey::Origin& survey, const fs::path& file) {
  if (product.position == survey.position) return;
  throw Error(ErrorCode::crs_mismatch, "the product stands in another local frame than the survey")
      .file(file.string())
      .hint("Give the survey that the products were made from.");
}

std::optional<report::RouteView> route_of(const fs::path& file) {
  if (file.empty()) return std::nullopt;
  const io::Json json = io::read_json(file);
  report::RouteView route;
  for (const io::Json& p : json.at("path_m").as_array()) {
    const auto& pair = p.as_array();
    if (pair.size() < 2)
      throw Error(ErrorCode::invalid_input, "a point of the path has no two coordinates").file(file.string());
    route.path.emplace_back(pair[0].as_real(), pair[1].as_real());
  }
  route.length_m = json.at("length_m").as_real();
  if (const io::Json* clearance = json.find("clearance_m"); clearance != nullptr && clearance->is_number())
    route.min_clearance_m = clearance->as_real();
  route.planner = "A*, 8-connected, no corner cut";
  if (const io::Json* ends = json.find("ends"); ends != nullptr && ends->is_string() && ends->as_string() != "given")
    route.planner += "; ends " + ends->as_string();
  return route;
}

// Height of the horizontal plane for footprints: the median foot of rocks, else of obstacles, else of targets.
std::optional<double> ground_height(const report::ReportData& data) {
  std::vector<double> heights;
  for (const auto& r : data.rocks)
    if (!r.rock.rejected) heights.push_back(r.rock.base_height_m);
  if (heights.empty())
    for (const auto& o : data.obstacles) heights.push_back(o.position.z());
  if (heights.empty())
    for (const auto& t : data.targets) heights.push_back(t.target.centre.z());
  if (heights.empty()) return std::nullopt;
  const auto middle = heights.begin() + static_cast<std::ptrdiff_t>(heights.size() / 2);
  std::nth_element(heights.begin(), middle, heights.end());
  return *middle;
}

void add_frames(report::ReportData& data, const survey::Survey& survey) {
  const std::optional<double> ground = ground_height(data);
  for (const survey::Frame& frame : survey.frames) {
    report::FrameView view;
    view.frame = frame;
    view.frame.image = fs::path(frame.image).filename().string();
    const survey::Camera* camera = survey.camera(frame.camera);
    if (ground && camera != nullptr)
      view.footprint = camera::footprint(*camera, frame.T_world_camera, *ground, 8, kFootprintRange_m);
    data.frames.push_back(std::move(view));
  }
}

// What the stages before left out and warned of, in the order of their names.
void add_stage_records(report::ReportData& data, const ReportInputs& in) {
  const fs::path folder = in.products / ".cairn";
  if (!fs::is_directory(folder)) return;
  std::set<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.is_regular_file() && entry.path().extension() == ".json") files.insert(entry.path());
  for (const fs::path& file : files) {
    const std::string stage = file.stem().string();
    if (!counts(in, stage)) continue;
    const io::Json json = io::read_json(file);
    if (stage == "report" || json.find("rejects") == nullptr) continue;
    for (const io::Json& r : json.at("rejects").as_array())
      data.rejects.push_back(
          {stage, {r.at("record").as_string(), r.at("reason").as_string(), r.at("message").as_string()}});
    if (const io::Json* warnings = json.find("warnings"))
      for (const io::Json& w : warnings->as_array()) {
        // Stages that read the same file warn of the same things.
        auto& all = data.provenance.warnings;
        if (std::find(all.begin(), all.end(), w.as_string()) == all.end()) all.push_back(w.as_string());
      }
  }
}

void add_run_record(report::ReportData& data, const fs::path& file) {
  if (!fs::exists(file)) return;
  const io::Json json = io::read_json(file);
  if (const io::Json* arguments = json.find("arguments")) data.provenance.options = *arguments;
  if (const io::Json* seed = json.find("seed"); seed != nullptr && seed->is_integer())
    data.provenance.seed = static_cast<std::uint64_t>(seed->as_integer());
  if (const io::Json* command = json.find("command"); command != nullptr && command->is_string())
    data.provenance.recipe = command->as_string();
}

// Tables and cloud, by content; photographs are left to run.json.
void add_input_digests(report::ReportData& data, const survey::Survey& survey, const fs::path& folder) {
  std::vector<fs::path> files;
  for (const char* name : {"survey.json", "frames.csv", "detections.csv", "tie_points.csv", "tie_observations.csv"})
    if (fs::exists(folder / name)) files.push_back(folder / name);
  if (const survey::Source* cloud = survey.source("cloud"))
    if (const fs::path file = io::resolve_reference(cloud->path, folder); fs::is_regular_file(file))
      files.push_back(file);
  for (const InputDigest& digest : digest_inputs(files))
    data.provenance.inputs.push_back({fs::path(digest.path).filename().string(), digest.sha256});
}

// Rocks found in the cloud alone, or split in review: the page shows an object for each.
void add_unlocated(report::ReportData& data) {
  std::set<survey::TargetId> located;
  for (const auto& t : data.targets) located.insert(t.target.id);
  for (const auto& view : data.rocks) {
    if (view.rock.rejected || !view.rock.mass || located.contains(view.rock.target)) continue;
    report::TargetView found;
    found.target.id = view.rock.target;
    found.target.object_class = view.rock.object_class;
    found.target.state = survey::TargetState::mapped;
    found.target.centre = view.rock.mass->centre_of_mass;
    data.targets.push_back(std::move(found));
  }
  std::sort(data.targets.begin(), data.targets.end(),
            [](const auto& a, const auto& b) { return a.target.id < b.target.id; });
}

class ReportStage final : public Stage {
 public:
  [[nodiscard]] std::string_view name() const override { return "report"; }
  [[nodiscard]] std::vector<std::string> uses() const override {
    return {"locate",   "segment",   "surface", "fragility", "terrain",
            "coverage", "obstacles", "costmap", "route",     "layers"};
  }
  [[nodiscard]] base::VisitOptions options() override { return base::bind_options(options_); }
  [[nodiscard]] Estimate estimate(const StageInputs&) const override {
    return {std::uint64_t{512} << 20U, std::uint64_t{16} << 20U};
  }
  Outcome run(const StageInputs& in, const fs::path& out, base::RunContext& ctx) override {
    fs::create_directories(out / "report");
    return report_stage({in.products, in.survey, in.available, false}, out / "report", options_, ctx);
  }

 private:
  ReportStageOptions options_;
};

}  // namespace

fs::path ReportInputs::product(std::string_view stage, const std::string& name) const {
  const fs::path file = products / name;
  return counts(*this, stage) && fs::exists(file) ? file : fs::path();
}

report::ReportData gather_report(const ReportInputs& in, const ReportStageOptions& options, base::RunContext& ctx) {
  report::ReportData data;
  data.provenance.version = base::kVersion;
  data.provenance.seed = ctx.seed;
  survey::Survey survey;
  if (!in.survey.empty()) {
    survey = io::read_survey(in.survey);
    data.manifest = survey.manifest;
    // Where the files lie on this machine is nobody else's business; run.json keeps it.
    for (survey::Source& source : data.manifest.sources) source.path = fs::path(source.path).filename().string();
    data.detections = survey.detections.size();
  }
  const fs::path targets = in.product("locate", "targets.json"), obstacles = in.product("obstacles", "obstacles.json");
  if (!targets.empty()) {
    io::TargetsFile file = io::read_targets(targets);
    if (in.survey.empty()) data.manifest.origin = file.frame;
    check_frame(file.frame, data.manifest.origin, targets);
    for (survey::Target& t : file.targets) data.targets.push_back({std::move(t), {}});
  }
  if (!obstacles.empty()) {
    io::ObstaclesFile file = io::read_obstacles(obstacles);
    if (in.survey.empty() && data.targets.empty()) data.manifest.origin = file.frame;
    check_frame(file.frame, data.manifest.origin, obstacles);
    data.obstacles = std::move(file.obstacles);
  }
  data.rocks = read_rock_views(in, ctx);
  add_unlocated(data);
  const auto surface = raster_of(in.product("terrain", "surface.tif"));
  const auto views = raster_of(in.product("coverage", "views.tif"));
  const auto costmap = raster_of(in.product("costmap", "costmap.tif"));
  add_raster(data, surface, report::RasterRole::surface, "m");
  if (surface) hide_interpolated(*surface, data.rasters.back().grid);
  add_raster(data, views, report::RasterRole::views, "views");
  add_raster(data, costmap, report::RasterRole::costmap, "cost");
  data.coverage = read_coverage_view(in, survey, views);
  data.route = route_of(in.product("route", "route.json"));
  if (!in.survey.empty()) {
    add_frames(data, survey);
    add_input_digests(data, survey, in.survey);
    if (options.page.photos && options.photos_per_object > 0) add_photos(data.targets, survey, in.survey, options, ctx);
    if (options.colours) data.colours = cloud_colours(survey, in.survey, options.colour_cell_m, ctx);
  }
  add_stage_records(data, in);
  if (in.read_run_record) add_run_record(data, in.products / "run.json");
  return data;
}

Outcome report_stage(const ReportInputs& in, const fs::path& folder, const ReportStageOptions& options,
                     base::RunContext& ctx) {
  ReportStageOptions checked = options;
  base::validate(base::bind_options(checked), "report");
  const report::ReportData data = gather_report(in, checked, ctx);
  ctx.check_stop();
  const std::string page = report::render_report(data, checked.page);
  base::write_file(folder / "index.html", page);

  std::size_t photos = 0, meshes = 0;
  for (const auto& t : data.targets) photos += t.photos.size();
  for (const auto& r : data.rocks) meshes += r.mesh ? 1U : 0U;
  constexpr std::array<std::pair<const char*, const char*>, 9> kProducts{{{"locate", "targets.json"},
                                                                          {"fragility", "rocks.json"},
                                                                          {"obstacles", "obstacles.json"},
                                                                          {"coverage", "coverage.json"},
                                                                          {"coverage", "gaps.json"},
                                                                          {"terrain", "surface.tif"},
                                                                          {"coverage", "views.tif"},
                                                                          {"costmap", "costmap.tif"},
                                                                          {"route", "route.json"}}};
  std::vector<std::string> missing;
  for (const auto& [stage, name] : kProducts)
    if (in.product(stage, name).empty()) missing.emplace_back(name);
  Outcome outcome;
  outcome.summary = io::Json::object({{"bytes", page.size()},
                                      {"objects", data.targets.size()},
                                      {"rocks", data.rocks.size()},
                                      {"meshes", meshes},
                                      {"photos", photos},
                                      {"gaps", data.coverage ? data.coverage->gaps.size() : std::size_t{0}},
                                      {"missing", io::Json(missing)}});
  return outcome;
}

std::unique_ptr<Stage> make_report_stage() {
  return std::make_unique<ReportStage>();
}

}  // namespace cairn::pipeline
