#include "pipeline/match_images.hpp"

#include <algorithm>
#include <limits>

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

// Views straight down from one height over level ground do not tell the focal length from that height: what must be
// said.
std::string height_note(const MatchedTies& ties) {
  if (!ties.ground_known || ties.start.empty()) return {};
  constexpr double kDown = 0.94;  // cosine of 20 degrees
  double least = std::numeric_limits<double>::infinity(), most = 0.0, sum = 0.0;
  for (const auto& frame : ties.start) {
    if (!(frame.T_world_camera.rotation.col(2).z() < -kDown)) return {};
    const double height = frame.T_world_camera.translation.z() - ties.ground_up_m;
    least = std::min(least, height);
    most = std::max(most, height);
    sum += height;
  }
  const double mean = sum / static_cast<double>(ties.start.size());
  constexpr double kOneHeight = 0.25;
  if (!(mean > 0.0) || most - least > kOneHeight * mean) return {};
  constexpr double kPercent = 0.01;
  return "All views look down from about one height (" + base::to_fixed(mean, 0) +
         " m above the ground): the images cannot tell the focal length from this height. Where the focal length is "
         "wrong by 1 %, the ground lies " +
         base::to_fixed(kPercent * mean, 1) +
         " m too high or too low and heights of objects are wrong by 1 %; horizontal positions keep the scale of the "
         "GPS positions. Control points on the ground or oblique views would settle it.";
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
  const std::string note = height_note(ties);
  result.one_height = !note.empty();
  if (result.one_height) {
    survey.manifest.notes.push_back(note);
    ctx.warn(note);
  }
  result.summary = summary_of(ties, ties.ties.size());
  if (result.one_height) result.summary.set("uncertain", note);
  survey.ties = std::move(ties.ties);
  ties.ties.clear();
  result.survey = std::move(survey);
  return result;
}

}  // namespace cairn::pipeline
