#include <cmath>
#include <map>

#include "base/error.hpp"
#include "io/csv.hpp"
#include "io/survey_folder.hpp"
#include "io/truth.hpp"
#include "pipeline/evaluate_inputs.hpp"

namespace cairn::pipeline {
namespace fs = std::filesystem;
namespace {

using evaluation::ClassAp;
using evaluation::TrueRegion;
using io::Json;
using survey::FrameId;

std::string stem(const std::string& name) {
  return fs::path(name).stem().string();
}

// The images of truth; results find theirs by name or number.
class Images {
 public:
  void add(FrameId id, const std::string& name, std::int64_t number) {
    if (!name.empty()) by_name_.emplace(stem(name), id);
    if (number >= 0) by_number_.emplace(number, id);
    last_ = std::max(last_, id.value);
  }
  // Images that truth does not have get ids of their own.
  FrameId find(const io::BoxImage& image) {
    if (!image.name.empty())
      if (const auto at = by_name_.find(stem(image.name)); at != by_name_.end()) return at->second;
    // A detector that numbers images names them by that number, and the other way round.
    if (image.number >= 0) {
      if (const auto at = by_number_.find(image.number); at != by_number_.end()) return at->second;
      if (const auto at = by_name_.find(std::to_string(image.number)); at != by_name_.end()) return at->second;
    }
    ++unknown_;
    return FrameId(++last_);
  }
  [[nodiscard]] std::size_t unknown() const { return unknown_; }

 private:
  std::map<std::string, FrameId> by_name_;
  std::map<std::int64_t, FrameId> by_number_;
  std::int64_t last_ = -1;
  std::size_t unknown_ = 0;
};

struct Truth {
  std::vector<TrueRegion> regions;
  Images images;
  std::map<std::string, std::string> categories;  // COCO: class number -> name
};

Truth truth_of_survey(const fs::path& path, const EvaluateOptions& options) {
  const survey::Truth truth = io::read_truth(path);
  const auto classes = scored_classes(truth, options.classes);
  std::map<survey::ObjectId, const survey::TruthObject*> objects;
  for (const auto& object : truth.objects) objects[object.id] = &object;
  Truth out;
  for (const auto& frame : truth.frames) out.images.add(frame.id, frame.image, frame.id.value);
  for (const auto& box : truth.boxes) {
    const auto found = objects.find(box.object);
    if (found == objects.end() || !classes.contains(found->second->object_class)) continue;
    const bool counts = box.whole && box.visible_share >= options.stages.min_visible_share;
    out.regions.push_back({box.frame, found->second->object_class, box.box, !counts, false});
  }
  return out;
}

Truth truth_of_boxes(const EvaluateInputs& in, const EvaluateOptions& options) {
  const io::BoxFile file = read_box_file(in.truth, in.truth_format, in.class_names);
  const auto classes = class_list(options.classes);
  const bool coco = file.format == io::BoxFormat::coco;
  Truth out;
  for (std::size_t i = 0; i < file.images.size(); ++i)
    out.images.add(FrameId(static_cast<std::int64_t>(i)), file.images[i].name, file.images[i].number);
  for (const auto& box : file.boxes) {
    if (!classes.empty() && !classes.contains(box.object_class)) continue;
    const bool ignored = box.ignored || (file.format == io::BoxFormat::mot && box.score == 0.0);
    out.regions.push_back(
        {FrameId(static_cast<std::int64_t>(box.image)), box.object_class, box.box, ignored, coco && ignored});
  }
  if (coco) {
    const Json json = io::read_json(in.truth);
    if (const Json* list = json.is_object() ? json.find("categories") : nullptr; list != nullptr)
      for (const auto& category : list->as_array())
        out.categories[std::to_string(category.at("id").as_integer())] = category.at("name").as_string();
  }
  return out;
}

// A detections.csv: frames by their ids.
std::vector<survey::Detection> read_table(const fs::path& path) {
  io::CsvReader csv(path);
  const auto frame = csv.column("frame_id"), name = csv.column("class"), score = csv.column("score");
  const auto xmin = csv.column("xmin_px"), ymin = csv.column("ymin_px");
  const auto xmax = csv.column("xmax_px"), ymax = csv.column("ymax_px");
  std::vector<survey::Detection> detections;
  while (csv.next()) {
    survey::Detection d;
    d.id = survey::DetectionId(static_cast<std::int64_t>(detections.size()));
    d.frame = FrameId(csv.integer(frame));
    d.object_class = std::string(csv.text(name));
    d.score = csv.real(score);
    d.box = {csv.real(xmin), csv.real(ymin), csv.real(xmax), csv.real(ymax)};
    detections.push_back(std::move(d));
  }
  return detections;
}

bool is_detection_table(const fs::path& path) {
  if (path.extension() != ".csv") return false;
  return io::CsvReader(path).find("frame_id").has_value();
}

std::vector<survey::Detection> detections_of(const EvaluateInputs& in, Truth& truth,
                                             std::vector<base::Reject>& rejects) {
  std::vector<survey::Detection> all;
  if (fs::is_directory(in.result) && fs::exists(in.result / "survey.json")) {
    all = io::read_survey(in.result).detections;
  } else if (fs::is_regular_file(in.result) && is_detection_table(in.result)) {
    all = read_table(in.result);
  } else {
    const io::BoxFile file = read_box_file(in.result, in.format, in.class_names);
    std::vector<FrameId> ids;
    for (const auto& image : file.images) ids.push_back(truth.images.find(image));
    for (const auto& box : file.boxes) {
      survey::Detection d;
      d.id = survey::DetectionId(static_cast<std::int64_t>(box.line));
      d.frame = ids[box.image];
      d.object_class = box.object_class;
      if (const auto named = truth.categories.find(box.object_class); named != truth.categories.end())
        d.object_class = named->second;
      d.score = box.score;
      d.box = box.box;
      all.push_back(std::move(d));
    }
  }
  std::erase_if(all, [&](const survey::Detection& d) {
    const bool finite = std::isfinite(d.box.xmin) && std::isfinite(d.box.ymin) && std::isfinite(d.box.xmax) &&
                        std::isfinite(d.box.ymax) && std::isfinite(d.score);
    if (!finite)
      rejects.push_back(
          {"detection " + std::to_string(d.id.value), "non_finite_box", "a side or the score is no number"});
    return !finite;
  });
  return all;
}

// Formats that know no classes leave them empty; then nothing is told apart by class.
void drop_classes_where_one_side_has_none(std::vector<survey::Detection>& detections, std::vector<TrueRegion>& truth) {
  const auto named = [](const auto& boxes) {
    return std::any_of(boxes.begin(), boxes.end(), [](const auto& b) { return !b.object_class.empty(); });
  };
  if (named(detections) && named(truth)) return;
  for (auto& d : detections) d.object_class = "object";
  for (auto& t : truth) t.object_class = "object";
}

Json to_json(const ClassAp& c) {
  const auto figure = [&](double value) { return c.truths == 0 ? Json() : Json(value); };
  return Json::object({{"ap50", figure(c.ap50())},
                       {"ap75", figure(c.ap75())},
                       {"ap50_95", figure(c.ap50_95())},
                       {"ap50_90", figure(c.ap50_90())},
                       {"truths", c.truths},
                       {"detections", c.detections},
                       {"tp", c.tp},
                       {"fp", c.fp},
                       {"fn", c.fn},
                       {"precision", optional_json(c.precision())},
                       {"recall", optional_json(c.recall())}});
}

}  // namespace

Outcome evaluate_detections(const EvaluateInputs& in, const EvaluateOptions& options, base::RunContext& ctx) {
  require_path(in.result, "the result");
  require_path(in.truth, "the truth");
  const auto simulated = truth_json(in.truth);
  Truth truth = simulated ? truth_of_survey(*simulated, options) : truth_of_boxes(in, options);
  Outcome outcome;
  auto detections = detections_of(in, truth, outcome.rejects);
  const auto classes = class_list(options.classes);
  if (!classes.empty())
    std::erase_if(detections,
                  [&](const auto& d) { return !d.object_class.empty() && !classes.contains(d.object_class); });
  drop_classes_where_one_side_has_none(detections, truth.regions);
  if (truth.images.unknown() > 0)
    ctx.warn(std::to_string(truth.images.unknown()) +
             " images of the result are not in the truth: their boxes count as false");
  const auto scores = evaluation::score_detections(detections, truth.regions, options.ap);
  Json per_class = Json::object();
  std::size_t tp = 0, fp = 0, fn = 0;
  for (const auto& c : scores.classes) {
    per_class.set(c.object_class, to_json(c));
    tp += c.tp;
    fp += c.fp;
    fn += c.fn;
  }
  const auto share = [](std::size_t part, std::size_t whole) {
    return whole == 0 ? Json() : Json(static_cast<double>(part) / static_cast<double>(whole));
  };
  outcome.summary = Json::object({{"kind", "detections"},
                                  {"images", scores.images},
                                  {"images_without_truth", truth.images.unknown()},
                                  {"detections", detections.size()},
                                  {"mean", Json::object({{"ap50", optional_json(scores.mean(&ClassAp::ap50))},
                                                         {"ap75", optional_json(scores.mean(&ClassAp::ap75))},
                                                         {"ap50_95", optional_json(scores.mean(&ClassAp::ap50_95))},
                                                         {"ap50_90", optional_json(scores.mean(&ClassAp::ap50_90))}})},
                                  {"tp", tp},
                                  {"fp", fp},
                                  {"fn", fn},
                                  {"precision", share(tp, tp + fp)},
                                  {"recall", share(tp, tp + fn)},
                                  {"classes", std::move(per_class)},
                                  {"rejects_by_reason", count_by_reason(outcome.rejects)}});
  return outcome;
}

}  // namespace cairn::pipeline
