#include "pipeline/detect_stage.hpp"

#include <atomic>
#include <map>
#include <optional>

#include "base/error.hpp"
#include "base/parallel.hpp"
#include "detection/detector.hpp"
#include "io/detections.hpp"
#include "io/image.hpp"
#include "io/survey_folder.hpp"

namespace cairn::pipeline {
namespace fs = std::filesystem;
namespace {

struct FrameResult {
  std::vector<detection::ScoredBox> boxes;
  std::size_t tiles = 0;
  std::optional<base::Reject> reject;
};

FrameResult detect_frame(const detection::Detector& detector, const survey::Frame& frame, const fs::path& folder) {
  const std::string record = "frame " + std::to_string(frame.id.value);
  FrameResult result;
  if (frame.image.empty()) {
    result.reject = {record, "no_image", "the frame names no image"};
    return result;
  }
  const fs::path path = io::resolve_reference(frame.image, folder);
  geometry::ColourImage image;
  try {
    image = io::read_colour_image(path);
  } catch (const base::Error& e) {
    result.reject = {record, "unreadable_image", e.what()};
    return result;
  }
  result.tiles = detector.tiles_of(image.width_px, image.height_px);
  result.boxes = detector.detect(image);
  return result;
}

}  // namespace

Outcome detect_stage(const DetectInputs& in, const fs::path& out, const detection::DetectOptions& options,
                     base::RunContext& ctx) {
  const survey::Survey survey = io::read_survey(in.survey);
  std::vector<std::string> names;
  if (!in.names.empty()) names = io::read_class_names(in.names);
  const detection::Detector detector(in.model, options, std::move(names));
  const auto& facts = detector.facts();
  ctx.info("decoder " + facts.decoder + ", input " + std::to_string(facts.input_width_px) + " x " +
           std::to_string(facts.input_height_px) + ", outputs " + facts.outputs);

  std::vector<FrameResult> results(survey.frames.size());
  std::atomic<std::uint64_t> done{0};
  base::parallel_for(survey.frames.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      ctx.check_stop();
      results[i] = detect_frame(detector, survey.frames[i], in.survey);
      ctx.progress("images", ++done, survey.frames.size());
    }
  });

  std::vector<survey::Detection> detections;
  std::vector<base::Reject> rejects;
  std::map<std::string, std::int64_t> by_class;
  std::size_t tiles = 0;
  for (std::size_t i = 0; i < results.size(); ++i) {
    tiles += results[i].tiles;
    if (results[i].reject) rejects.push_back(*results[i].reject);
    for (const auto& found : results[i].boxes) {
      survey::Detection d;
      d.id = survey::DetectionId(static_cast<std::int64_t>(detections.size()) + 1);
      d.frame = survey.frames[i].id;
      d.object_class = detector.class_name(found.object_class);
      d.score = found.score;
      d.box = found.box;
      ++by_class[d.object_class];
      detections.push_back(std::move(d));
    }
  }
  if (rejects.size() == survey.frames.size())
    throw base::Error(base::ErrorCode::failed_precondition, "no image of the survey could be read")
        .file((in.survey / "frames.csv").string())
        .found(rejects.empty() ? "no frames" : rejects.front().record + ": " + rejects.front().message)
        .hint("Check the column image of frames.csv");
  for (const auto& reject : rejects) ctx.warn(reject.record + ": " + reject.message);
  io::write_detections(out, detections);
  io::Json classes = io::Json::object();
  for (const auto& [name, count] : by_class) classes.set(name, count);
  return {io::Json::object({{"frames", survey.frames.size()},
                            {"images", survey.frames.size() - rejects.size()},
                            {"tiles", tiles},
                            {"detections", detections.size()},
                            {"detections_by_class", std::move(classes)},
                            {"decoder", facts.decoder},
                            {"input_px", io::Json(std::vector<double>{static_cast<double>(facts.input_width_px),
                                                                      static_cast<double>(facts.input_height_px)})},
                            {"outputs", facts.outputs},
                            {"rejects_by_reason", count_by_reason(rejects)}}),
          std::move(rejects)};
}

}  // namespace cairn::pipeline
