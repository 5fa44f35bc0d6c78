#include <algorithm>
#include <cmath>
#include <map>

#include "base/error.hpp"
#include "evaluation/tracking_scores.hpp"
#include "io/csv.hpp"
#include "io/survey_folder.hpp"
#include "io/tracks_csv.hpp"
#include "io/truth.hpp"
#include "pipeline/evaluate_inputs.hpp"

namespace cairn::pipeline {
namespace fs = std::filesystem;
namespace {

using base::Error;
using base::ErrorCode;
using evaluation::IdentifiedBox;
using evaluation::TrueBox;
using io::Json;

struct Scores {
  evaluation::ClearScore clear;
  evaluation::IdentityScore identity;
  evaluation::HotaScore hota;
  std::size_t ignored_truths = 0, ignored_tracks = 0;
};

Scores score(const std::vector<TrueBox>& truth, const std::vector<IdentifiedBox>& tracks,
             const EvaluateOptions& options) {
  const auto sequence = evaluation::make_sequence(truth, tracks, options.iou);
  return {evaluation::clear_score(sequence, options.iou), evaluation::identity_score(sequence, options.iou),
          evaluation::hota_score(sequence), sequence.ignored_truths, sequence.ignored_tracks};
}

void add(Scores& sum, const Scores& s) {
  evaluation::add(sum.clear, s.clear);
  evaluation::add(sum.identity, s.identity);
  evaluation::add(sum.hota, s.hota);
  sum.ignored_truths += s.ignored_truths;
  sum.ignored_tracks += s.ignored_tracks;
}

Json to_json(const Scores& s) {
  return Json::object({{"mota", s.clear.mota()},
                       {"motp", s.clear.motp()},
                       {"idf1", s.identity.idf1()},
                       {"hota", s.hota.hota()},
                       {"det_a", s.hota.det_a()},
                       {"ass_a", s.hota.ass_a()},
                       {"loc_a", s.hota.loc_a()},
                       {"tp", s.clear.tp},
                       {"fp", s.clear.fp},
                       {"fn", s.clear.fn},
                       {"id_switches", s.clear.id_switches},
                       {"precision", s.clear.precision()},
                       {"recall", s.clear.recall()},
                       {"idtp", s.identity.idtp},
                       {"idfp", s.identity.idfp},
                       {"idfn", s.identity.idfn},
                       {"id_precision", s.identity.precision()},
                       {"id_recall", s.identity.recall()},
                       {"objects", s.clear.objects},
                       {"mostly_tracked", s.clear.mostly_tracked},
                       {"mostly_lost", s.clear.mostly_lost},
                       {"fragmentations", s.clear.fragmentations},
                       {"truth_boxes", s.clear.truths},
                       {"track_boxes", s.clear.tp + s.clear.fp},
                       {"ignored_truth_boxes", s.ignored_truths},
                       {"ignored_track_boxes", s.ignored_tracks}});
}

void set_members(Json& into, const Json& from) {
  for (const auto& [name, value] : from.as_object()) into.set(name, value);
}

std::int64_t identity(const io::ImageBox& box, const fs::path& path) {
  if (box.track < 0)
    throw Error(ErrorCode::invalid_input, "a box without identity")
        .file(path.string())
        .record("line " + std::to_string(box.line))
        .allowed("ids from 0 or 1 up")
        .hint("Detections are scored with 'cairn evaluate detections'");
  return box.track;
}

bool finite(const geometry::PixelBox& b) {
  return std::isfinite(b.xmin) && std::isfinite(b.ymin) && std::isfinite(b.xmax) && std::isfinite(b.ymax);
}

// Number of the frame of a box: its own, else the place of its image.
std::int64_t frame_number(const io::BoxFile& file, const io::ImageBox& box) {
  const auto number = file.images[box.image].number;
  return number >= 0 ? number : static_cast<std::int64_t>(box.image) + 1;
}

std::vector<TrueBox> truth_of_boxes(const fs::path& path, const EvaluateInputs& in, const EvaluateOptions& options) {
  const io::BoxFile file = read_box_file(path, in.truth_format, in.class_names);
  const auto classes = class_list(options.classes);
  const bool mot = file.format == io::BoxFormat::mot;
  const bool pedestrians =
      mot && classes.empty() &&
      std::any_of(file.boxes.begin(), file.boxes.end(), [](const auto& b) { return b.object_class == "1"; });
  std::vector<TrueBox> truth;
  for (const auto& box : file.boxes) {
    if (!finite(box.box)) continue;
    bool ignored = box.ignored || (mot && box.score == 0.0);
    if (pedestrians) {
      const bool distractor =
          box.object_class == "2" || box.object_class == "7" || box.object_class == "8" || box.object_class == "12";
      if (!distractor && (box.object_class != "1" || ignored)) continue;
      ignored = distractor;
    } else if (!classes.empty() && !classes.contains(box.object_class)) {
      continue;
    }
    truth.push_back({frame_number(file, box), identity(box, path), box.box, ignored});
  }
  return truth;
}

std::vector<IdentifiedBox> tracks_of_boxes(const fs::path& path, const EvaluateInputs& in,
                                           std::vector<base::Reject>& rejects) {
  const io::BoxFile file = read_box_file(path, in.format, in.class_names);
  std::vector<IdentifiedBox> tracks;
  for (const auto& box : file.boxes) {
    if (finite(box.box)) tracks.push_back({frame_number(file, box), identity(box, path), box.box});
    else
      rejects.push_back(
          {path.string() + ", line " + std::to_string(box.line), "non_finite_box", "a side is no number"});
  }
  return tracks;
}

// Of a simulated survey: frames are numbered in the order of time.
Scores score_survey(const fs::path& truth_path, const EvaluateInputs& in, const EvaluateOptions& options) {
  const survey::Truth truth = io::read_truth(truth_path);
  const survey::Survey survey = io::read_survey(truth_path.parent_path());
  const auto rows = io::read_tracks(in.result, survey);
  const auto classes = scored_classes(truth, options.classes);
  std::vector<const survey::Frame*> order;
  for (const auto& frame : truth.frames) order.push_back(&frame);
  std::stable_sort(order.begin(), order.end(), [](const auto* a, const auto* b) { return a->time_ns < b->time_ns; });
  std::map<survey::FrameId, std::int64_t> number;
  for (const auto* frame : order) number.emplace(frame->id, static_cast<std::int64_t>(number.size()));
  std::map<survey::ObjectId, const survey::TruthObject*> objects;
  for (const auto& object : truth.objects) objects[object.id] = &object;

  std::vector<TrueBox> boxes;
  for (const auto& box : truth.boxes) {
    const auto object = objects.find(box.object);
    const auto frame = number.find(box.frame);
    if (object == objects.end() || frame == number.end() || !classes.contains(object->second->object_class)) continue;
    const bool counts = box.whole && box.visible_share >= options.stages.min_visible_share;
    boxes.push_back({frame->second, box.object.value, box.box, !counts});
  }
  std::vector<IdentifiedBox> tracks;
  for (const auto& row : rows)
    if (const auto frame = number.find(row.box.frame); frame != number.end() && classes.contains(row.box.object_class))
      tracks.push_back({frame->second, row.track.value, row.box.box});
  return score(boxes, tracks, options);
}

// The truth of sequence NAME in a folder of truths.
fs::path truth_of_sequence(const fs::path& folder, const std::string& name) {
  for (const auto& candidate : {folder / (name + ".txt"), folder / name / "gt.txt", folder / name / "gt" / "gt.txt"})
    if (fs::exists(candidate)) return candidate;
  throw Error(ErrorCode::not_found, "no truth for sequence '" + name + "'")
      .file(folder.string())
      .allowed(name + ".txt, " + name + "/gt.txt or " + name + "/gt/gt.txt");
}

}  // namespace

Outcome evaluate_tracks(const EvaluateInputs& in, const EvaluateOptions& options, base::RunContext& ctx) {
  require_path(in.result, "the result");
  require_path(in.truth, "the truth");
  Outcome outcome;
  if (!fs::is_directory(in.result)) {
    const auto simulated = truth_json(in.truth);
    const Scores s = simulated ? score_survey(*simulated, in, options)
                               : score(truth_of_boxes(in.truth, in, options),
                                       tracks_of_boxes(in.result, in, outcome.rejects), options);
    outcome.summary = Json::object({{"kind", "tracks"}});
    set_members(outcome.summary, to_json(s));
    return outcome;
  }
  std::vector<fs::path> results;
  for (const auto& entry : fs::directory_iterator(in.result))
    if (entry.path().extension() == ".txt") results.push_back(entry.path());
  std::sort(results.begin(), results.end());
  if (results.empty())
    throw Error(ErrorCode::not_found, "no tracks in the folder").file(in.result.string()).allowed("files NAME.txt");
  Scores sum;
  Json sequences = Json::object();
  for (const auto& path : results) {
    ctx.check_stop();
    const std::string name = path.stem().string();
    const Scores s = score(truth_of_boxes(truth_of_sequence(in.truth, name), in, options),
                           tracks_of_boxes(path, in, outcome.rejects), options);
    add(sum, s);
    sequences.set(name, to_json(s));
  }
  outcome.summary = Json::object({{"kind", "tracks"}});
  set_members(outcome.summary, to_json(sum));
  outcome.summary.set("sequences", std::move(sequences));
  return outcome;
}

}  // namespace cairn::pipeline
