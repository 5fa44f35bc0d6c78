#include "pipeline/segment_stage.hpp"

#include <algorithm>
#include <array>
#include <functional>
#include <optional>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "base/number_text.hpp"
#include "geodesy/crs.hpp"
#include "geodesy/local_frame.hpp"
#include "io/cloud.hpp"
#include "io/contact_csv.hpp"
#include "io/csv.hpp"
#include "io/survey_folder.hpp"
#include "io/targets_json.hpp"
#include "pipeline/segment_large.hpp"
#include "pipeline/survey_sources.hpp"

namespace cairn::pipeline {
namespace fs = std::filesystem;
namespace {

using base::Error;
using base::ErrorCode;
using geometry::Vec3;
using segmentation::Label;

std::vector<std::string> split_classes(const std::string& text) {
  std::vector<std::string> classes;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    const auto name = base::trim(std::string_view(text).substr(begin, end - begin));
    if (!name.empty()) classes.emplace_back(name);
    begin = end + 1;
  }
  return classes;
}

bool seen(const survey::ContactVertex& v) {
  return v.observed;
}

double observed_share(const segmentation::RockCut& rock) {
  if (rock.contact.empty()) return rock.shape.observed_share();
  return static_cast<double>(std::count_if(rock.contact.begin(), rock.contact.end(), seen)) /
         static_cast<double>(rock.contact.size());
}

io::Json contact_json(const segmentation::RockCut& rock) {
  io::Json contact = io::Json::array();
  for (const auto& v : rock.contact)
    contact.push(io::Json::object({{"pad", v.pad},
                                   {"order", v.order},
                                   {"position_m", io::Json(v.position)},
                                   {"status", v.observed ? "observed" : "inferred"},
                                   {"sigma_m", v.sigma_m}}));
  if (rock.contact.empty())
    for (const auto& sample : rock.shape.contact)
      contact.push(io::Json::object(
          {{"position_m", io::Json(sample.position)}, {"status", sample.observed ? "observed" : "inferred"}}));
  return contact;
}

io::Json segment_json(const segmentation::RockCut& rock) {
  return io::Json::object({{"id", rock.target.value},
                           {"class", rock.object_class},
                           {"rejected", false},
                           {"reasons", io::Json::array()},
                           {"message", ""},
                           {"method", rock.method},
                           {"point_count", rock.points.size()},
                           {"point_spacing_m", rock.shape.spacing},
                           {"noise_m", rock.noise},
                           {"height_m", rock.shape.height},
                           {"threshold_m", rock.threshold},
                           {"ground_noise_m", rock.ground.noise},
                           {"ground_up_m", rock.ground.up_at_centre},
                           {"ground_slope", std::vector<double>{rock.ground.slope.x(), rock.ground.slope.y()}},
                           {"sides_seen_share", rock.shape.sides_seen_share},
                           {"contact_observed_share", observed_share(rock)},
                           {"contact", contact_json(rock)},
                           {"notes", io::Json(rock.notes)}});
}

// Contact lines of all rocks; `back` takes a local position to the coordinates written.
io::ContactFile contact_file(const segmentation::RockCuts& cuts, const std::function<Vec3(const Vec3&)>& back) {
  io::ContactFile file;
  file.crs = "local";
  for (const auto& rock : cuts.rocks)
    for (auto vertex : rock.contact) {
      vertex.position = back(vertex.position);
      file.rows.push_back({rock.target.value, vertex});
    }
  return file;
}

std::int64_t id_of(const base::Reject& reject) {
  return base::parse_integer(std::string_view(reject.record).substr(std::string_view("target ").size())).value_or(-1);
}

// The survey's own word on a cloud: its CRS where the file has none, and where it lies against the poses.
struct Placement {
  std::string crs;
  std::optional<geometry::Similarity> T_world_source;
};

Placement placement_of(const SegmentFiles& in, const std::string& file_crs) {
  Placement placement{file_crs, std::nullopt};
  if (in.survey.empty()) return placement;
  const auto survey = io::read_survey(in.survey);
  if (const auto* source = survey.source("cloud")) {
    if (!source->crs.empty()) placement.crs = source->crs;
    placement.T_world_source = source->T_world_source;
  }
  return placement;
}

class SegmentStage final : public Stage {
 public:
  SegmentStage() { options_.keep = "labelled"; }
  [[nodiscard]] std::string_view name() const override { return "segment"; }
  [[nodiscard]] std::vector<std::string> uses() const override { return {"locate"}; }
  [[nodiscard]] base::VisitOptions options() override { return base::bind_options(options_); }

  [[nodiscard]] Estimate estimate(const StageInputs& in) const override {
    const auto survey = io::read_survey(in.survey);
    if (!has_cloud(survey)) return {};
    std::error_code ignored;
    const auto bytes = fs::file_size(io::resolve_reference(survey.source("cloud")->path, in.survey), ignored);
    if (ignored) return {};
    // A point of some 30 bytes on disk becomes a position, its columns and two labels.
    return {6 * bytes, options_.keep == "all" ? 2 * bytes : bytes / 4};
  }

  Outcome run(const StageInputs& in, const fs::path& out, base::RunContext& ctx) override {
    base::validate(options(), "segment");
    const auto survey = io::read_survey(in.survey);
    auto loaded = load_cloud(in.survey, survey, ctx);
    const auto local = loaded.cloud.positions;
    // Without located targets the rocks are sought in the cloud itself.
    const bool guided = std::find(in.available.begin(), in.available.end(), "locate") != in.available.end();
    std::vector<segmentation::RockTarget> rocks;
    if (guided) {
      rocks = rock_targets(io::read_targets(in.products / "targets.json").targets, options_);
    } else {
      geometry::PointCloud shape;
      shape.positions = local;
      rocks = segmentation::find_rock_targets(shape, ctx);
    }
    auto result = segment_targets(std::move(loaded.cloud), local, rocks, {}, options_, ctx);
    io::CloudWriteOptions write;
    write.crs_wkt = write.crs = geodesy::LocalFrame(survey.manifest.origin.position).raster_crs_wkt();
    io::write_cloud(out / "labelled.las", result.cloud, write);
    io::write_contact_csv(out / "contact.csv", contact_file(result.cuts, [](const Vec3& p) { return p; }));
    base::write_file(out / "segments.json", segments_json(result.cuts, rocks).dump() + "\n");
    return std::move(result.outcome);
  }

 private:
  SegmentOptions options_;
};

}  // namespace

void SegmentOptions::visit(base::OptionVisitor& visitor) {
  visitor.text("classes", classes, "target classes that are rocks, comma-separated");
  visitor.choice("keep", keep, {"all", "labelled"}, "points written: all, or those with a label");
  visitor.flag("intensity-labels", intensity_labels, "intensity: 1 rock, 2 basal contact, 0 pedestal and all else");
  visitor.real("tile-m", tile_m, 0.0, 100000.0,
               "edge of a tile, m, where a LAS cloud without targets goes by tile; 0: only where memory is short");
  rocks.visit(visitor);
}

std::vector<segmentation::RockTarget> rock_targets(const std::vector<survey::Target>& targets,
                                                   const SegmentOptions& options) {
  const auto classes = split_classes(options.classes);
  std::vector<segmentation::RockTarget> rocks;
  for (const auto& t : targets) {
    if (t.state == survey::TargetState::deregistered) continue;
    if (std::find(classes.begin(), classes.end(), t.object_class) == classes.end()) continue;
    segmentation::RockTarget rock{t.id, t.object_class, t.centre.head<2>()};
    // The fitted body's cylinder is the closer one.
    const auto cylinder = t.refined ? std::optional(t.refined->cylinder) : t.bcylinder;
    if (t.bcylinder) rock.radius = t.bcylinder->radius;
    if (cylinder) rock.low = cylinder->bottom, rock.high = cylinder->top;
    rocks.push_back(std::move(rock));
  }
  return rocks;
}

io::Json segments_json(const segmentation::RockCuts& cuts, const std::vector<segmentation::RockTarget>& targets) {
  std::vector<std::pair<std::int64_t, io::Json>> rows;
  for (const auto& rock : cuts.rocks) rows.emplace_back(rock.target.value, segment_json(rock));
  for (const auto& reject : cuts.rejects) {
    const std::int64_t id = id_of(reject);
    const auto target = std::find_if(targets.begin(), targets.end(), [id](const auto& t) { return t.id.value == id; });
    rows.emplace_back(id, io::Json::object({{"id", id},
                                            {"class", target == targets.end() ? "" : target->object_class},
                                            {"rejected", true},
                                            {"reasons", io::Json(std::vector<std::string>{reject.reason})},
                                            {"message", reject.message}}));
  }
  std::sort(rows.begin(), rows.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  io::Json list = io::Json::array();
  for (auto& row : rows) list.push(std::move(row.second));
  return io::Json::object({{"schema_version", 1}, {"segments", std::move(list)}});
}

Segmented segment_cloud(geometry::PointCloud cloud, const std::vector<Vec3>& local,
                        const std::vector<survey::Target>& targets, const SegmentOptions& options,
                        base::RunContext& ctx) {
  return segment_targets(std::move(cloud), local, rock_targets(targets, options), {}, options, ctx);
}

Segmented segment_targets(geometry::PointCloud cloud, const std::vector<Vec3>& local,
                          const std::vector<segmentation::RockTarget>& rocks,
                          const segmentation::RockGuidance& guidance, const SegmentOptions& options,
                          base::RunContext& ctx) {
  geometry::PointCloud shape;
  shape.positions = local;
  Segmented result;
  result.cuts = segmentation::segment_rocks(shape, rocks, guidance, options.rocks, ctx);
  result.cloud = std::move(cloud);
  segmentation::add_label_columns(result.cloud, result.cuts);
  if (options.intensity_labels) result.cloud.intensity.assign(local.size(), 0);
  std::array<std::size_t, 5> counts{};
  for (std::size_t i = 0; i < local.size(); ++i) {
    const Label label = result.cuts.labels[i];
    ++counts[static_cast<std::size_t>(label)];
    if (options.intensity_labels && label == Label::rock) result.cloud.intensity[i] = 1;
    if (options.intensity_labels && label == Label::basal_contact) result.cloud.intensity[i] = 2;
    if (options.keep == "all" || label != Label::unlabelled) result.kept.push_back(i);
  }
  if (result.kept.size() < local.size()) result.cloud = result.cloud.subset(result.kept);
  std::size_t with_contact = 0;
  for (const auto& rock : result.cuts.rocks) with_contact += !rock.contact.empty();
  auto& outcome = result.outcome;
  outcome.rejects = result.cuts.rejects;
  outcome.summary = io::Json::object({{"points", local.size()},
                                      {"targets", rocks.size()},
                                      {"rocks", result.cuts.rocks.size()},
                                      {"rocks_with_contact", with_contact},
                                      {"rejected", outcome.rejects.size()},
                                      {"rejected_by_reason", count_by_reason(outcome.rejects)},
                                      {"rock_points", counts[2]},
                                      {"pedestal_points", counts[3]},
                                      {"basal_contact_points", counts[4]},
                                      {"terrain_points", counts[1]}});
  return result;
}

std::vector<segmentation::RockPick> read_picks(const fs::path& path) {
  io::CsvReader csv(path);
  const auto x = csv.column("x"), y = csv.column("y"), z = csv.column("z"), rock = csv.column("rock");
  std::vector<segmentation::RockPick> picks;
  while (csv.next()) picks.push_back({{csv.real(x), csv.real(y), csv.real(z)}, csv.integer(rock, 0, 1) == 1});
  return picks;
}

fs::path contact_beside(const fs::path& labelled) {
  return fs::path(labelled).replace_extension(".contact.csv");
}

Outcome segment_file(const SegmentFiles& in, const fs::path& out_las, const fs::path& out_contact,
                     const SegmentOptions& options, base::RunContext& ctx) {
  const bool guided = !in.targets.empty();
  if (goes_by_tile(in, options, ctx)) {
    const auto T = placement_of(in, "").T_world_source;
    const auto forth = [&](const Vec3& p) -> Vec3 { return T ? *T * p : p; };
    auto large = segment_large(in, out_las, forth, options, ctx);
    const auto back = [&](const Vec3& p) -> Vec3 { return T ? T->inverse() * p : p; };
    io::write_contact_csv(out_contact, contact_file(large.cuts, back));
    large.outcome.summary.set("guided", false);
    large.outcome.summary.set("segments", segments_json(large.cuts, large.targets).at("segments"));
    return std::move(large.outcome);
  }
  const auto targets = guided ? io::read_targets(in.targets) : io::TargetsFile{};
  auto file = io::read_cloud(in.cloud);
  for (const auto& warning : file.facts.warnings) ctx.warn(in.cloud.filename().string() + ": " + warning);
  if (file.cloud.empty())
    throw Error(ErrorCode::invalid_input, "the cloud has no points").file(in.cloud.string()).allowed("at least 1");
  const auto placement = placement_of(in, file.facts.crs);
  const bool declared = !placement.crs.empty() && placement.crs != "local";
  std::optional<geodesy::CrsConverter> converter;
  if (guided && declared) converter.emplace(placement.crs, geodesy::LocalFrame(targets.frame.position));
  if (guided && !declared)
    ctx.warn(in.cloud.filename().string() + ": no CRS is declared; taken to be in the frame of " +
             in.targets.filename().string());
  const auto forth = [&](const Vec3& p) -> Vec3 {
    const Vec3 q = converter ? converter->to_local(p) : p;
    return placement.T_world_source ? *placement.T_world_source * q : q;
  };
  const auto back = [&](const Vec3& p) -> Vec3 {
    const Vec3 q = placement.T_world_source ? placement.T_world_source->inverse() * p : p;
    return converter ? converter->from_local(q) : q;
  };
  auto local = file.cloud.positions;
  if (converter) converter->to_local(local);
  if (placement.T_world_source)
    for (auto& p : local) p = *placement.T_world_source * p;

  segmentation::RockGuidance guidance;
  if (!in.picks.empty()) {
    guidance.picks = read_picks(in.picks);
    for (auto& pick : guidance.picks) pick.position = forth(pick.position);
  }
  if (!in.contact.empty())
    for (const auto& row : io::read_contact_csv(in.contact).rows) {
      auto vertex = row.vertex;
      vertex.position = forth(vertex.position);
      guidance.contacts[row.rock_id].push_back(vertex);
    }
  std::vector<segmentation::RockTarget> rocks;
  if (guided) {
    rocks = rock_targets(targets.targets, options);
  } else {
    geometry::PointCloud shape;
    shape.positions = local;
    rocks = segmentation::find_rock_targets(shape, ctx);
  }
  for (const auto& [id, contact] : guidance.contacts) {
    const auto known = std::any_of(rocks.begin(), rocks.end(), [&](const auto& r) { return r.id.value == id; });
    if (!known) ctx.warn("contact of rock " + std::to_string(id) + ": there is no such target; left out");
  }
  auto result = segment_targets(std::move(file.cloud), local, rocks, guidance, options, ctx);
  io::CloudWriteOptions write;
  write.crs = file.facts.crs;
  if (!file.facts.crs.empty()) write.crs_wkt = geodesy::crs_wkt(file.facts.crs);
  if (file.las) write.las = &*file.las;
  io::write_cloud(out_las, result.cloud, write);
  io::write_contact_csv(out_contact, contact_file(result.cuts, back));
  auto& summary = result.outcome.summary;
  summary.set("guided", guided);
  summary.set("segments", segments_json(result.cuts, rocks).at("segments"));
  return std::move(result.outcome);
}

std::unique_ptr<Stage> make_segment_stage() {
  return std::make_unique<SegmentStage>();
}

}  // namespace cairn::pipeline
