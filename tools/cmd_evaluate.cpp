// cairn evaluate detections|tracks|targets|trajectory|segmentation RESULT --truth TRUTH
#include "base/atomic_file.hpp"
#include "base/number_text.hpp"
#include "io/detections.hpp"
#include "pipeline/evaluate_segmentation.hpp"
#include "pipeline/evaluate_stage.hpp"
#include "pipeline/run_record.hpp"
#include "tools/command.hpp"

namespace cairn::tools {
namespace {

namespace fs = std::filesystem;
using io::Json;

std::string number(const Json& value, int decimals = 3) {
  if (!value.is_number()) return "-";
  return value.is_integer() ? std::to_string(value.as_integer()) : base::to_fixed(value.as_real(), decimals);
}

// "label  a 1  b 2": one line of figures by their names.
std::string line(const std::string& label, const Json& values, const std::vector<const char*>& names) {
  std::string text = label;
  for (const char* name : names)
    if (const Json* value = values.find(name); value != nullptr)
      text += "  " + std::string(name) + " " + number(*value);
  return text + "\n";
}

std::string text_of_detections(const Json& s) {
  std::string text = line("mean", s.at("mean"), {"ap50", "ap75", "ap50_95", "ap50_90"});
  for (const auto& [name, c] : s.at("classes").as_object())
    text += line("class '" + name + "'", c,
                 {"ap50", "ap75", "ap50_95", "ap50_90", "truths", "detections", "precision", "recall"});
  return text;
}

std::string text_of_tracks(const Json& s) {
  const std::vector<const char*> figures{"mota", "motp",        "idf1",           "hota",       "fp",
                                         "fn",   "id_switches", "mostly_tracked", "mostly_lost"};
  std::string text;
  if (const Json* sequences = s.find("sequences"); sequences != nullptr)
    for (const auto& [name, sequence] : sequences->as_object()) text += line(name, sequence, figures);
  return text + line("all", s, figures);
}

std::string text_of_targets(const Json& s) {
  std::string text;
  for (const auto& [name, stage] : s.at("stages").as_object())
    text += line(name, stage, {"tp", "fp", "fn", "precision", "recall"});
  const auto errors = [&](const std::string& label, const Json& of) {
    text += line(label + " centre error, m:", of.at("centre_error_m"), {"count", "median", "p95", "max"});
    text += line(label + " cylinder:", of.at("cylinder"), {"iou", "volume_ratio", "contained_share"});
    text += line(label + " normalised error squared:", of.at("nees"), {"count", "mean"});
  };
  errors("located,", s);
  if (s.at("refined").at("centre_error_m").at("count").as_integer() > 0) errors("refined,", s.at("refined"));
  return text + "An object counts as missed where it was seen whole in " + number(s.at("seen_whole_frames")) +
         " frames; bias removed: " + s.at("bias_removed").as_string() + "\n";
}

std::string text_of_trajectory(const Json& s) {
  const Json& rpe = s.at("rpe");
  return number(s.at("pairs")) + " pairs by " + s.at("match").as_string() + ", aligned: " + s.at("align").as_string() +
         "\n" + line("ate, m:", s.at("ate"), {"rmse_m", "mean_m", "median_m", "max_m"}) +
         line("ate, rotation, deg:", s.at("ate_rotation_deg"), {"rmse", "median", "max"}) +
         line("rpe, m:", rpe.at("translation_m"), {"rmse", "mean", "median", "max"}) +
         line("rpe, rotation, deg:", rpe.at("rotation_deg"), {"rmse", "mean", "median", "max"});
}

std::string text_of_segmentation(const Json& s) {
  std::string text = line("rock points:", s, {"iou", "dice", "precision", "recall"});
  text += line("rocks:", s.at("instances"), {"true", "found", "matched", "precision", "recall"});
  text += line("contact line to the rim, mean, m:", s.at("contact").at("mean_m"), {"count", "median", "p95", "max"});
  text += line("alpha error, deg:", s.at("alpha_error_deg"), {"count", "median", "p95", "max"});
  return text + line("volume error, share:", s.at("volume_error_share"), {"count", "median", "p95", "max"});
}

class EvaluateCommand final : public Command {
 public:
  void declare(Arguments& arguments) override {
    arguments.word("kind", kind_, {"detections", "tracks", "targets", "trajectory", "segmentation"}, "What is scored");
    arguments.input("result", in_.result,
                    "Boxes, tracks, the folder of located targets, a trajectory, or a labelled cloud");
    arguments.option("truth", in_.truth,
                     "What it is scored against: truth.json, boxes, tracks, a trajectory or a cloud");
    std::vector<std::string> formats{"auto"};
    formats.insert(formats.end(), io::box_format_names().begin(), io::box_format_names().end());
    arguments.choice("format", in_.format, formats, "Format of the result's boxes; auto: from their content");
    arguments.choice("truth-format", in_.truth_format, formats,
                     "Format of the truth's boxes; auto: from their content");
    arguments.option("names", names_, "Class names of boxes that number classes, one a line");
    arguments.option("survey", in_.survey, "targets: the survey they were located in; default: the truth's folder");
    arguments.option("contact", segmentation_.contact, "segmentation: contact lines; default: those beside the cloud");
    arguments.option("rocks", segmentation_.rocks,
                     "segmentation: folder of surface or fragility; default: bodies are made here");
    arguments.option("truth-rocks", segmentation_.truth_rocks,
                     "segmentation: truth.json with rims and volumes; default: beside the true cloud");
    arguments.output(out_, "Write the summary here too, with how it was made", false);
    arguments.options(base::bind_options(options_));
    arguments.options(base::bind_options(segmentation_options_));
    arguments.example("cairn evaluate detections detections.csv --truth survey/truth.json --json");
    arguments.example("cairn evaluate tracks out.txt --truth gt.txt --json");
    arguments.example("cairn evaluate targets located --truth survey/truth.json --remove-bias survey --json");
    arguments.example("cairn evaluate segmentation labelled.las --truth truth.las --json");
    arguments.example("cairn evaluate trajectory survey --truth groundtruth.txt --align sim3 --json");
  }

  CommandResult run(const Arguments& arguments, base::RunContext& ctx) override {
    base::validate(base::bind_options(options_), "evaluate");
    base::validate(base::bind_options(segmentation_options_), "evaluate");
    if (in_.truth.empty())
      throw base::Error(base::ErrorCode::invalid_argument, "nothing to score against").hint("Name it with --truth");
    if (!names_.empty()) in_.class_names = io::read_class_names(names_);
    for (const auto& path : {in_.result, in_.truth})
      if (!fs::exists(path))
        throw base::Error(base::ErrorCode::not_found, "no such file or folder").file(path.string());
    if (arguments.common.dry_run)
      return {Json::object({{"would_score", in_.result.string()}, {"truth", in_.truth.string()}}),
              "Would score " + in_.result.string() + " against " + in_.truth.string() + "\n"};
    if (out_.empty()) {
      const auto outcome = score(ctx);
      return {outcome.summary, text_of(outcome.summary)};
    }
    const auto outcome = pipeline::run_to_file(
        out_, arguments.common.overwrite,
        {"evaluate",
         arguments.resolved(false),
         ctx.seed,
         pipeline::digest_inputs({in_.result, in_.truth}),
         {},
         {},
         {},
         {}},
        [&](const fs::path& staged) {
          auto scored = score(ctx);
          base::write_file(staged, scored.summary.dump() + "\n");
          return scored;
        },
        ctx);
    return {outcome.summary, text_of(outcome.summary)};
  }

 private:
  [[nodiscard]] pipeline::Outcome score(base::RunContext& ctx) const {
    if (kind_ == "detections") return pipeline::evaluate_detections(in_, options_, ctx);
    if (kind_ == "tracks") return pipeline::evaluate_tracks(in_, options_, ctx);
    if (kind_ == "targets") return pipeline::evaluate_targets(in_, options_, ctx);
    if (kind_ == "segmentation") {
      auto in = segmentation_;
      in.labelled = in_.result;
      in.truth = in_.truth;
      auto how = segmentation_options_;
      how.least_iou = options_.iou;
      return pipeline::evaluate_segmentation(in, how, ctx);
    }
    return pipeline::evaluate_trajectory(in_, options_, ctx);
  }

  [[nodiscard]] std::string text_of(const Json& summary) const {
    if (kind_ == "detections") return text_of_detections(summary);
    if (kind_ == "tracks") return text_of_tracks(summary);
    if (kind_ == "targets") return text_of_targets(summary);
    if (kind_ == "segmentation") return text_of_segmentation(summary);
    return text_of_trajectory(summary);
  }

  std::string kind_;
  pipeline::EvaluateInputs in_;
  fs::path names_, out_;
  pipeline::EvaluateOptions options_;
  pipeline::EvaluateSegmentationInputs segmentation_;
  pipeline::EvaluateSegmentationOptions segmentation_options_;
};

}  // namespace
}  // namespace cairn::tools

CAIRN_COMMAND_MAIN(cairn::tools::EvaluateCommand)
