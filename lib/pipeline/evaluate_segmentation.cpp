#include "pipeline/evaluate_segmentation.hpp"

#include <unistd.h>
#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <tuple>

#include "base/angle.hpp"
#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "evaluation/line_distance.hpp"
#include "evaluation/point_labels.hpp"
#include "evaluation/statistics.hpp"
#include "fragility/tipping.hpp"
#include "geometry/kd_tree.hpp"
#include "io/cloud.hpp"
#include "io/contact_csv.hpp"
#include "io/mesh.hpp"
#include "io/rocks_json.hpp"
#include "io/truth.hpp"
#include "pipeline/evaluate_inputs.hpp"
#include "pipeline/surface_stage.hpp"
#include "segmentation/labels.hpp"

namespace cairn::pipeline {
namespace fs = std::filesystem;
namespace {

using base::Error;
using base::ErrorCode;
using evaluation::Polyline;
using geometry::Vec3;
using io::Json;

struct Labels {
  std::vector<std::uint8_t> label;
  std::vector<std::uint32_t> instance;
};

Labels labels_of(const geometry::PointCloud& cloud, const fs::path& path) {
  const auto* label = cloud.scalar(segmentation::kLabelColumn);
  const auto* instance = cloud.scalar(segmentation::kTargetIdColumn);
  if (label == nullptr)
    throw Error(ErrorCode::invalid_input, "the cloud has no column 'label'")
        .file(path.string())
        .hint("A labelled cloud is made by cairn segment; a true one needs the same column");
  Labels result;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    result.label.push_back(static_cast<std::uint8_t>(std::clamp(label->values[i], 0.0, 255.0)));
    result.instance.push_back(instance == nullptr ? 0U : static_cast<std::uint32_t>(instance->values[i]));
  }
  return result;
}

bool same_order(const std::vector<Vec3>& a, const std::vector<Vec3>& b, double tolerance) {
  if (a.size() != b.size()) return false;
  for (std::size_t i = 0; i < a.size(); ++i)
    if ((a[i] - b[i]).squaredNorm() > tolerance * tolerance) return false;
  return true;
}

// The found labels of each true point; the number of found points that no true point took.
std::size_t pair_up(const geometry::PointCloud& found, const geometry::PointCloud& truth, double tolerance,
                    Labels& labels) {
  if (same_order(found.positions, truth.positions, tolerance)) return 0;
  Labels paired;
  paired.label.assign(truth.size(), 0);
  paired.instance.assign(truth.size(), segmentation::kNoTarget);
  std::size_t taken = 0;
  if (!found.empty()) {
    const geometry::KdTree tree(found.positions);
    std::vector<std::uint8_t> used(found.size(), 0);
    for (std::size_t i = 0; i < truth.size(); ++i)
      for (const auto& near : tree.within(truth.positions[i], tolerance)) {
        if (used[near.index] != 0) continue;
        used[near.index] = 1;
        paired.label[i] = labels.label[near.index];
        paired.instance[i] = labels.instance[near.index];
        ++taken;
        break;
      }
  }
  labels = std::move(paired);
  return found.size() - taken;
}

// What was made of one rock.
struct Found {
  std::optional<geometry::MassProperties> mass;
  std::vector<Polyline> contact;
  std::optional<double> alpha_deg, inner_deg, outer_deg;  // as fragility gives them
  std::optional<survey::Quantiles> alpha_quantiles_deg;
  std::string grade;
};
using FoundRocks = std::map<std::int64_t, Found>;

void add_vertex(std::map<std::int64_t, Polyline>& pads, std::int64_t pad, const Vec3& position, bool closed) {
  pads[pad].points.push_back(position);
  pads[pad].closed = closed;
}

void set_contact(Found& found, const std::map<std::int64_t, Polyline>& pads) {
  found.contact.clear();
  for (const auto& [pad, line] : pads) found.contact.push_back(line);
}

void read_contacts(const fs::path& path, FoundRocks& rocks) {
  auto rows = io::read_contact_csv(path).rows;
  std::stable_sort(rows.begin(), rows.end(), [](const auto& a, const auto& b) {
    return std::tuple(a.rock_id, a.vertex.pad, a.vertex.order) < std::tuple(b.rock_id, b.vertex.pad, b.vertex.order);
  });
  std::map<std::int64_t, std::map<std::int64_t, Polyline>> lines;
  for (const auto& row : rows) add_vertex(lines[row.rock_id], row.vertex.pad, row.vertex.position, row.vertex.closed);
  for (const auto& [id, pads] : lines) set_contact(rocks[id], pads);
}

// "contact" of <id>.json: "line" where it stands, else the older "points".
void take_contact(const Json& json, Found& found) {
  std::map<std::int64_t, Polyline> pads;
  if (const Json* line = json.find("line"); line != nullptr && line->is_array()) {
    for (const auto& v : line->as_array())
      add_vertex(pads, v.at("pad").as_integer(), v.at("position_m").as_vec3(), v.at("closed").as_bool());
  } else if (const Json* points = json.find("points"); points != nullptr && points->is_array()) {
    for (const auto& v : points->as_array()) add_vertex(pads, 0, v.at("position_m").as_vec3(), true);
  }
  if (!pads.empty()) set_contact(found, pads);
}

std::optional<double> alpha_of(const std::optional<survey::TippingEdge>& edge) {
  if (!edge) return std::nullopt;
  return base::rad_to_deg(edge->alpha_rad);
}

void take_record(const survey::Rock& rock, Found& found) {
  found.mass = rock.mass;
  found.grade = survey::name_of(rock.tipping.grade);
  found.alpha_deg = alpha_of(rock.tipping.critical);
  if (rock.tipping.inner) found.inner_deg = alpha_of(rock.tipping.inner->critical);
  if (rock.tipping.outer) found.outer_deg = alpha_of(rock.tipping.outer->critical);
  if (rock.tipping.uncertainty)
    if (const auto* q = rock.tipping.uncertainty->find("alpha_min_deg")) found.alpha_quantiles_deg = *q;
}

// Records of `surface`: <id>.json for every rock.
void read_bodies(const fs::path& folder, FoundRocks& rocks) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string stem = entry.path().stem().string();
    const bool number =
        !stem.empty() && std::all_of(stem.begin(), stem.end(), [](char c) { return c >= '0' && c <= '9'; });
    if (entry.path().extension() == ".json" && number) files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  for (const auto& file : files) {
    const Json json = io::read_json(file);
    const survey::Rock rock = io::rock_from_json(json.at("rock"));
    if (rock.rejected) continue;
    Found& found = rocks[rock.target.value];
    found.mass = rock.mass;
    if (const Json* contact = json.find("contact"); contact != nullptr && contact->is_object())
      take_contact(*contact, found);
  }
}

void read_rocks(const fs::path& path, FoundRocks& rocks) {
  if (!fs::exists(path)) throw Error(ErrorCode::not_found, "no such file or folder of rocks").file(path.string());
  fs::path records = path;
  if (fs::is_directory(path)) {
    records = path / "rocks.json";
    if (!fs::exists(records)) {
      read_bodies(path, rocks);
      return;
    }
  }
  // Not read_rocks: rocks of a cloud without an origin stand in no frame.
  const Json json = io::read_json(records);
  for (const auto& item : json.at("rocks").as_array()) {
    const survey::Rock rock = io::rock_from_json(item);
    take_record(rock, rocks[rock.target.value]);
  }
}

void make_bodies(const SurfaceFiles& files, FoundRocks& rocks, base::RunContext& ctx) {
  const base::StagedFolder scratch(fs::temp_directory_path() / ("cairn_evaluate_" + std::to_string(::getpid())));
  (void)surface_file(files, scratch.path(), {}, ctx);
  read_bodies(scratch.path(), rocks);
}

std::optional<fs::path> truth_beside(const EvaluateSegmentationInputs& in) {
  if (!in.truth_rocks.empty()) {
    require_path(in.truth_rocks, "truth of the rocks");
    return truth_json(in.truth_rocks);
  }
  fs::path folder = in.truth;
  folder.replace_extension();
  if (auto found = truth_json(folder); found && fs::is_directory(folder)) return found;
  if (const fs::path beside = in.truth.parent_path() / "truth.json"; fs::exists(beside)) return beside;
  return std::nullopt;
}

std::vector<Polyline> closed_rings(const std::vector<std::vector<Vec3>>& rings) {
  std::vector<Polyline> lines;
  for (const auto& ring : rings) lines.push_back({ring, true});
  return lines;
}

std::optional<double> alpha_deg(const Vec3& centre_of_mass, const std::vector<Polyline>& contact) {
  std::vector<Vec3> points;
  for (const auto& line : contact) points.insert(points.end(), line.points.begin(), line.points.end());
  geometry::MassProperties mass;  // alpha depends on the centre of mass alone
  mass.volume = 1.0;
  mass.centre_of_mass = centre_of_mass;
  mass.inertia_per_density = geometry::Mat3::Identity();
  const auto tipping = fragility::tipping(mass, points);
  if (!tipping.critical) return std::nullopt;
  return base::rad_to_deg(tipping.edges[*tipping.critical].alpha);
}

Json difference(const std::optional<double>& found, const std::optional<double>& truth) {
  return found && truth ? Json(*found - *truth) : Json();
}

Json quantiles_json(const survey::Quantiles& q) {
  return Json::object({{"p05", q.p05}, {"p16", q.p16}, {"p50", q.p50}, {"p84", q.p84}, {"p95", q.p95}});
}

Json overlap_json(const evaluation::Overlap& overlap) {
  return Json::object({{"iou", optional_json(overlap.iou())},
                       {"dice", optional_json(overlap.dice())},
                       {"precision", optional_json(overlap.precision())},
                       {"recall", optional_json(overlap.recall())},
                       {"true_points", overlap.both + overlap.true_only}});
}

// Pooled over the rocks that have them.
struct Errors {
  std::vector<double> mean_m, p95_m, hausdorff_m, alpha_deg, contact_alpha_deg, volume;
};

Json contact_json(const Found& found, const survey::TruthObject& truth, double step, Errors& errors) {
  const auto d = evaluation::line_distance(found.contact, closed_rings(truth.contact_rim), step);
  if (d.samples == 0) return {};
  errors.mean_m.push_back(d.mean);
  errors.p95_m.push_back(d.p95);
  errors.hausdorff_m.push_back(d.hausdorff);
  return Json::object({{"mean_m", d.mean},
                       {"p95_m", d.p95},
                       {"from_true_mean_m", d.from_true},
                       {"hausdorff_m", d.hausdorff},
                       {"pads", found.contact.size()}});
}

Json alpha_json(const Found& found, const survey::TruthObject& truth, Errors& errors) {
  const Vec3& centre = truth.centre_of_mass;
  const auto rim = alpha_deg(centre, closed_rings(truth.contact_rim));
  if (!rim) return {};
  const auto contact_only = alpha_deg(centre, found.contact);
  auto own = found.alpha_deg;
  if (!own && found.mass) own = alpha_deg(found.mass->centre_of_mass, found.contact);
  if (own) errors.alpha_deg.push_back(std::abs(*own - *rim));
  if (contact_only) errors.contact_alpha_deg.push_back(std::abs(*contact_only - *rim));
  Json json = Json::object({{"true_rim_deg", *rim},
                            {"true_bearing_deg", optional_json(alpha_deg(centre, closed_rings(truth.contact_bearing)))},
                            {"alpha_deg", optional_json(own)},
                            {"error_deg", difference(own, rim)},
                            {"contact_error_deg", difference(contact_only, rim)},
                            {"inner_deg", optional_json(found.inner_deg)},
                            {"outer_deg", optional_json(found.outer_deg)}});
  if (found.alpha_quantiles_deg) {
    const auto& q = *found.alpha_quantiles_deg;
    json.set("quantiles_deg", quantiles_json(q));
    json.set("interval_90_holds_truth", q.p05 <= *rim && *rim <= q.p95);
  }
  if (!found.grade.empty()) json.set("grade", found.grade);
  return json;
}

// Ascending, of a body of unit density.
Vec3 principal_moments(const geometry::MassProperties& mass) {
  return Eigen::SelfAdjointEigenSolver<geometry::Mat3>(mass.inertia_per_density, Eigen::EigenvaluesOnly).eigenvalues();
}

// Largest relative error of a principal moment, where the truth keeps the body's mesh.
Json inertia_error(const geometry::MassProperties& found, const survey::TruthObject& truth, const fs::path& folder) {
  if (truth.mesh.empty() || !fs::exists(folder / truth.mesh)) return {};
  const Vec3 in_truth = principal_moments(geometry::mass_properties(io::read_mesh(folder / truth.mesh).mesh));
  return (principal_moments(found).cwiseQuotient(in_truth) - Vec3::Ones()).cwiseAbs().maxCoeff();
}

Json volume_json(const Found& found, const survey::TruthObject& truth, const fs::path& folder, Errors& errors) {
  if (!found.mass || !(truth.volume_m3 > 0.0)) return {};
  const double error = found.mass->volume / truth.volume_m3 - 1.0;
  errors.volume.push_back(std::abs(error));
  return Json::object({{"true_m3", truth.volume_m3},
                       {"m3", found.mass->volume},
                       {"error_share", error},
                       {"principal_inertia_error_share", inertia_error(*found.mass, truth, folder)},
                       {"centre_of_mass_error_m", (found.mass->centre_of_mass - truth.centre_of_mass).norm()}});
}

Json instances_json(const evaluation::LabelScores& scores, double least_iou) {
  double sum = 0.0;
  for (const auto& rock : scores.rocks)
    if (rock.matched) sum += rock.overlap.iou().value_or(0.0);
  return Json::object({{"least_iou", least_iou},
                       {"true", scores.rocks.size()},
                       {"found", scores.found_rocks},
                       {"matched", scores.matched},
                       {"precision", scores.precision()},
                       {"recall", scores.recall()},
                       {"mean_iou", scores.matched > 0 ? Json(sum / static_cast<double>(scores.matched)) : Json()}});
}

// What is true of the rocks, and the folder that its files are named in.
struct TrueRocks {
  survey::Truth truth;
  fs::path folder;
};

Json rock_json(const evaluation::RockOverlap& rock, const FoundRocks& found, const std::optional<TrueRocks>& truth,
               double step, Errors& errors) {
  Json row = Json::object({{"true_id", static_cast<std::int64_t>(rock.true_id)},
                           {"id", rock.id ? Json(static_cast<std::int64_t>(*rock.id)) : Json()},
                           {"matched", rock.matched},
                           {"iou", optional_json(rock.overlap.iou())},
                           {"dice", optional_json(rock.overlap.dice())}});
  if (!truth || !rock.matched) return row;
  const auto& objects = truth->truth.objects;
  const auto object = std::find_if(objects.begin(), objects.end(), [&](const auto& o) {
    return o.id.value == static_cast<std::int64_t>(rock.true_id);
  });
  const auto record = found.find(static_cast<std::int64_t>(*rock.id));
  if (object == objects.end() || record == found.end()) return row;
  row.set("contact", contact_json(record->second, *object, step, errors));
  row.set("alpha", alpha_json(record->second, *object, errors));
  row.set("volume", volume_json(record->second, *object, truth->folder, errors));
  return row;
}

FoundRocks found_rocks(const EvaluateSegmentationInputs& in, bool bodies_wanted, base::RunContext& ctx) {
  FoundRocks rocks;
  if (!in.rocks.empty()) read_rocks(in.rocks, rocks);
  else if (bodies_wanted) make_bodies({in.labelled, in.contact}, rocks, ctx);
  fs::path contact = in.contact;
  if (contact.empty()) {
    contact = in.labelled;
    contact.replace_extension(".contact.csv");
    if (!fs::exists(contact)) return rocks;
  }
  require_path(contact, "contact lines");
  read_contacts(contact, rocks);
  return rocks;
}

}  // namespace

void EvaluateSegmentationOptions::visit(base::OptionVisitor& visitor) {
  visitor.real("tolerance-m", tolerance_m, 0.0, 1.0, "segmentation: points nearer than this are the same [m]");
  visitor.real("step-m", step_m, 1e-4, 1.0, "segmentation: distances of contact lines are taken so densely [m]");
}

Outcome evaluate_segmentation(const EvaluateSegmentationInputs& in, const EvaluateSegmentationOptions& options,
                              base::RunContext& ctx) {
  const auto found_cloud = io::read_cloud(in.labelled).cloud;
  const auto true_cloud = io::read_cloud(in.truth).cloud;
  Labels found = labels_of(found_cloud, in.labelled);
  const Labels truth = labels_of(true_cloud, in.truth);
  const std::size_t unpaired = pair_up(found_cloud, true_cloud, options.tolerance_m, found);
  if (!found_cloud.empty() && unpaired == found_cloud.size())
    throw Error(ErrorCode::invalid_input, "no point of the cloud lies at a true point")
        .file(in.labelled.string())
        .hint("Both must hold the same points; a larger --tolerance-m pairs clouds that were rounded");
  if (unpaired > 0)
    ctx.warn(std::to_string(unpaired) + " points of " + in.labelled.filename().string() + " have no true point");
  const auto scores =
      evaluation::score_labels({found.label, truth.label, found.instance, truth.instance}, options.least_iou);
  std::optional<TrueRocks> rocks_truth;
  if (const auto path = truth_beside(in)) rocks_truth = TrueRocks{io::read_truth(*path), path->parent_path()};
  const bool volumes = rocks_truth && std::any_of(rocks_truth->truth.objects.begin(), rocks_truth->truth.objects.end(),
                                                  [](const auto& o) { return o.volume_m3 > 0.0; });
  FoundRocks rocks;
  if (rocks_truth) rocks = found_rocks(in, volumes, ctx);

  Errors errors;
  Json rows = Json::array();
  for (const auto& rock : scores.rocks) rows.push(rock_json(rock, rocks, rocks_truth, options.step_m, errors));
  const char* names[] = {"none", "terrain", "rock", "pedestal", "basal_contact"};
  Json classes = Json::object();
  for (std::size_t k = 0; k < evaluation::kLabels; ++k) classes.set(names[k], overlap_json(scores.classes[k]));
  Outcome outcome;
  outcome.summary =
      Json::object({{"points", true_cloud.size()},
                    {"unpaired", unpaired},
                    {"iou", optional_json(scores.rock.iou())},
                    {"dice", optional_json(scores.rock.dice())},
                    {"precision", optional_json(scores.rock.precision())},
                    {"recall", optional_json(scores.rock.recall())},
                    {"classes", std::move(classes)},
                    {"instances", instances_json(scores, options.least_iou)},
                    {"contact", Json::object({{"mean_m", to_json(evaluation::spread(errors.mean_m))},
                                              {"p95_m", to_json(evaluation::spread(errors.p95_m))},
                                              {"hausdorff_m", to_json(evaluation::spread(errors.hausdorff_m))}})},
                    {"alpha_error_deg", to_json(evaluation::spread(errors.alpha_deg))},
                    {"contact_alpha_error_deg", to_json(evaluation::spread(errors.contact_alpha_deg))},
                    {"volume_error_share", to_json(evaluation::spread(errors.volume))},
                    {"rocks", std::move(rows)}});
  return outcome;
}

}  // namespace cairn::pipeline
