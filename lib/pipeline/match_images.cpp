#include "pipeline/match_images.hpp"

#include <algorithm>

#include "base/error.hpp"
#include "base/number_text.hpp"
#include "camera/dji_pose.hpp"
#include "io/image.hpp"
#include "io/survey_folder.hpp"

namespace cairn::pipeline {
namespace fs = std::filesystem;
namespace {

using adjustment::MatchedTies;
using io::Json;

Json pairs_json(const MatchedTies& ties) {
  Json pairs = Json::array();
  for (const auto& pair : ties.pairs)
    pairs.push(Json::object({{"a", pair.a.value},
                             {"b", pair.b.value},
                             {"matched", pair.matched},
                             {"consistent", pair.consistent},
                             {"model", adjustment::name_of(pair.model)},
                             {"reason", pair.reason}}));
  return pairs;
}

Json turned_json(const MatchedTies& ties) {
  Json turned = Json::array();
  for (const auto& frame : ties.turned)
    turned.push(Json::object({{"frame", frame.frame.value},
                              {"turned_deg", frame.turned_deg},
                              {"disagreement_before_m", frame.before_m},
                              {"disagreement_after_m", frame.after_m},
                              {"pairs", frame.pairs}}));
  return turned;
}

Json summary_of(const MatchedTies& ties, std::size_t points) {
  const auto used =
      std::count_if(ties.pairs.begin(), ties.pairs.end(), [](const auto& pair) { return pair.reason.empty(); });
  Json unmatched = Json::array();
  for (const auto id : ties.unmatched) unmatched.push(id.value);
  Json rejects = Json::array();
  for (const auto& reject : ties.rejects)
    rejects.push(Json::object({{"record", reject.record}, {"reason", reject.reason}, {"message", reject.message}}));
  return Json::object({{"features", ties.features},
                       {"pairs_tried", ties.pairs.size()},
                       {"pairs_used", static_cast<std::int64_t>(used)},
                       {"points", points},
                       {"observations", ties.observations},
                       {"median_residual_px", ties.median_residual_px},
                       {"ground_up_m", ties.ground_known ? Json(ties.ground_up_m) : Json()},
                       {"turned_frames", turned_json(ties)},
                       {"unmatched_frames", std::move(unmatched)},
                       {"rejects", std::move(rejects)},
                       {"pairs", pairs_json(ties)}});
}

// The mirrored twin of a camera, added where it is new; the camera itself where the turn does not change it.
survey::CameraId twin_of(survey::CameraId id, survey::Manifest& manifest) {
  const auto own = std::find_if(manifest.cameras.begin(), manifest.cameras.end(),
                                [&](const survey::Camera& c) { return c.id == id; });
  survey::Camera half = camera::turned_half(*own);
  if (half == *own) return id;
  half.name += ", turned by 180 degrees";
  survey::CameraId largest = id;
  for (const auto& known : manifest.cameras) {
    half.id = known.id;
    if (half == known) return known.id;
    largest = std::max(largest, known.id);
  }
  half.id = survey::CameraId(largest.value + 1);
  manifest.cameras.push_back(half);
  return half.id;
}

void put_right(const MatchedTies& ties, survey::Survey& survey, base::RunContext& ctx) {
  survey.frames = ties.frames;
  if (ties.turned.empty()) return;
  std::string names;
  for (const auto& turned : ties.turned) {
    auto& frame = *std::find_if(survey.frames.begin(), survey.frames.end(),
                                [&](const survey::Frame& f) { return f.id == turned.frame; });
    constexpr int kHalf = 180;
    if (turned.turned_deg == kHalf) frame.camera = twin_of(frame.camera, survey.manifest);
    names += (names.empty() ? "" : ", ") + std::to_string(turned.frame.value) + " (by " +
             std::to_string(turned.turned_deg) + " degrees; its " + std::to_string(turned.pairs) +
             " pairs disagreed by " + base::to_fixed(turned.before_m, 1) + " m on the ground, now by " +
             base::to_fixed(turned.after_m, 1) + " m)";
  }
  const std::string note =
      "The images show that the pixels of these frames were turned after the exposure; their poses were turned with "
      "them: " +
      names + ".";
  survey.manifest.notes.push_back(note);
  ctx.warn(note);
}

}  // namespace

MatchedSurvey match_images(survey::Survey survey, const fs::path& folder, const adjustment::TieMatchOptions& options,
                           base::RunContext& ctx) {
  if (std::all_of(survey.frames.begin(), survey.frames.end(), [](const auto& f) { return f.image.empty(); }))
    throw base::Error(base::ErrorCode::failed_precondition, "no frame of the survey names an image")
        .file((folder / "frames.csv").string())
        .hint("Import the survey with its images");
  const auto load = [&](const survey::Frame& frame) {
    return io::read_grey_image(io::resolve_reference(frame.image, folder), 2 * options.max_width_px - 1);
  };
  MatchedSurvey result;
  result.matching = adjustment::match_ties(survey, load, options, ctx);
  auto& ties = result.matching;
  if (ties.ties.empty())
    throw base::Error(base::ErrorCode::failed_precondition, "no two images share enough points")
        .file(folder.string())
        .found(ties.rejects.empty() ? std::to_string(ties.pairs.size()) + " pairs of images tried"
                                    : ties.rejects.front().message)
        .allowed("images that overlap, with texture")
        .hint("Look at the images; raise --match-max-features or --match-max-width-px");
  put_right(ties, survey, ctx);
  result.summary = summary_of(ties, ties.ties.size());
  survey.ties = std::move(ties.ties);
  ties.ties.clear();
  result.survey = std::move(survey);
  return result;
}

}  // namespace cairn::pipeline
