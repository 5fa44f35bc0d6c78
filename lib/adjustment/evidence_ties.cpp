#include "adjustment/evidence_ties.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "adjustment/pose_hypotheses.hpp"
#include "adjustment/robust.hpp"
#include "base/number_text.hpp"
#include "camera/projection.hpp"

namespace cairn::adjustment {
namespace {

using geometry::RigidTransform;
using geometry::Vec2;
using geometry::Vec3;

constexpr double kInfinite = std::numeric_limits<double>::infinity();
constexpr double kExplainedRatio = 0.1;     // after / before below which a hypothesis explains coarse points
constexpr double kClearlyBetter = 0.5;      // after / before for a frame that is within the limit as it is
constexpr double kLargestExplained = 50.0;  // px: above this nothing is explained, whatever the ratio

struct Seen {
  Vec3 p_world;
  Vec2 pixel;
};

using SeenByFrame = std::map<survey::FrameId, std::vector<Seen>>;

SeenByFrame collect(const survey::Survey& survey) {
  SeenByFrame seen;
  for (const auto& tie : survey.ties) {
    if (!tie.p_world.allFinite()) continue;
    for (const auto& observation : tie.observations)
      if (observation.pixel.allFinite()) seen[observation.frame].push_back({tie.p_world, observation.pixel});
  }
  return seen;
}

std::vector<Seen> thinned(const std::vector<Seen>& seen, std::size_t most) {
  if (seen.size() <= most) return seen;
  std::vector<Seen> kept;
  kept.reserve(most);
  for (std::size_t i = 0; i < most; ++i) kept.push_back(seen[i * seen.size() / most]);
  return kept;
}

// Distances; infinite where the point cannot be projected.
std::vector<double> errors(const survey::Camera& camera, const RigidTransform& pose, const std::vector<Seen>& seen,
                           const Vec2& shift = Vec2::Zero()) {
  std::vector<double> result;
  result.reserve(seen.size());
  for (const auto& s : seen) {
    const auto pixel = camera::project_world(camera, pose, s.p_world);
    result.push_back(pixel ? (s.pixel + shift - *pixel).norm() : kInfinite);
  }
  return result;
}

FrameReprojection reprojection(const survey::Frame& frame, const survey::Camera& camera, const std::vector<Seen>& seen,
                               std::size_t min_observations, std::vector<double>& all) {
  FrameReprojection result;
  result.frame = frame.id;
  result.observations = seen.size();
  std::vector<double> distance, dx, dy;
  for (const auto& s : seen) {
    const auto pixel = camera::project_world(camera, frame.T_world_camera, s.p_world);
    if (!pixel) {
      ++result.behind;
      distance.push_back(kInfinite);
      continue;
    }
    const Vec2 d = s.pixel - *pixel;
    distance.push_back(d.norm());
    dx.push_back(d.x());
    dy.push_back(d.y());
  }
  all.insert(all.end(), distance.begin(), distance.end());
  result.median_px = median(distance);
  result.bias_px = {median(dx), median(dy)};
  result.spread_px = {robust_sigma(dx), robust_sigma(dy)};
  result.judged = seen.size() >= min_observations;
  return result;
}

// One way to read the survey, and the bad frames it would explain.
struct Candidate {
  TieVerdict verdict;
  int parts = 1;
  std::size_t bad = 0;                        // frames explained that were beyond the limit
  std::vector<double> before, after, scales;  // of verdict.frames
};

struct JudgedFrame {
  const survey::Frame* frame = nullptr;
  const survey::Camera* camera = nullptr;
  std::vector<Seen> seen;
  double before_px = 0.0;
  // Within the limit as declared: explains nothing by itself, but shares the convention of the others
  // where a hypothesis makes it clearly better too.
  bool sound = false;
};

bool explains(double before, double after, double max_median) {
  return after <= max_median || (after <= kLargestExplained && after <= kExplainedRatio * before);
}

// Observations made on an image of another size: observed = scale * projected, from the corner.
std::optional<double> other_scale(const JudgedFrame& judged) {
  constexpr double kLeastCoordinate = 0.1;  // of the image's size: ratios of smaller numbers are all noise
  constexpr double kLeastChange = 0.005;
  const double least_x = kLeastCoordinate * static_cast<double>(judged.camera->width_px);
  const double least_y = kLeastCoordinate * static_cast<double>(judged.camera->height_px);
  std::vector<double> ratios;
  for (const auto& s : judged.seen) {
    const auto pixel = camera::project_world(*judged.camera, judged.frame->T_world_camera, s.p_world);
    if (!pixel) continue;
    if (pixel->x() > least_x) ratios.push_back(s.pixel.x() / pixel->x());
    if (pixel->y() > least_y) ratios.push_back(s.pixel.y() / pixel->y());
  }
  if (ratios.size() < 4) return std::nullopt;
  const double scale = median(std::move(ratios));
  if (!(scale > 0.01 && scale < 100.0) || std::abs(scale - 1.0) < kLeastChange) return std::nullopt;
  return scale;
}

void add_explained(Candidate& candidate, const JudgedFrame& judged, double after, double scale = 1.0) {
  candidate.verdict.frames.push_back(judged.frame->id);
  if (!judged.sound) ++candidate.bad;
  candidate.before.push_back(judged.before_px);
  candidate.after.push_back(after);
  candidate.scales.push_back(scale);
}

// Images of another size; one candidate a scale (to a hundredth).
std::vector<Candidate> scale_candidates(const std::vector<JudgedFrame>& frames, double max_median) {
  std::map<std::string, Candidate> by_scale;
  for (const auto& judged : frames) {
    const auto scale = judged.sound ? std::nullopt : other_scale(judged);
    if (!scale) continue;
    auto rescaled = judged.seen;
    for (auto& s : rescaled) s.pixel /= *scale;
    const double after = median(errors(*judged.camera, judged.frame->T_world_camera, rescaled));
    if (explains(judged.before_px, after, max_median))
      add_explained(by_scale[base::to_fixed(*scale, 2)], judged, after, *scale);
  }
  std::vector<Candidate> candidates;
  for (auto& [key, candidate] : by_scale) {
    const double scale = median(candidate.scales);
    candidate.verdict.code = "image_scale";
    candidate.verdict.scale = scale;
    candidate.verdict.meaning = "the tie observations were made on images " + base::to_fixed(scale, 4) +
                                " times the size the camera is declared for";
    candidate.verdict.remedy =
        "give the camera of the image size the observations were made on (import again with "
        "--scale-images), or scale the observations";
    candidates.push_back(std::move(candidate));
  }
  return candidates;
}

Candidate pose_candidate(const PoseHypothesis& hypothesis, const std::vector<JudgedFrame>& frames, double max_median) {
  Candidate candidate;
  candidate.parts = hypothesis.parts();
  candidate.verdict.code = hypothesis.code();
  candidate.verdict.meaning = hypothesis.meaning();
  candidate.verdict.remedy = hypothesis.remedy();
  for (const auto& judged : frames) {
    const auto pose = hypothesis.apply(judged.frame->T_world_camera);
    double after = median(errors(*judged.camera, pose, judged.seen));
    if (hypothesis.turned_deg % 180 != 0) {
      // A raster turned by 90 degrees has its centre at (height/2, width/2).
      const double half_difference = 0.5 * static_cast<double>(judged.camera->width_px - judged.camera->height_px);
      after = std::min(after, median(errors(*judged.camera, pose, judged.seen, {half_difference, -half_difference})));
    }
    if (judged.sound ? after < kClearlyBetter * judged.before_px : explains(judged.before_px, after, max_median))
      add_explained(candidate, judged, after);
  }
  return candidate;
}

// Fewest verdicts: the candidate that explains most frames first (ties: fewer parts, smaller error), then
// again with what is left. Near-nadir poses make several readings fit single frames by chance; the one
// mistake that was made fits all.
void cover(std::vector<JudgedFrame> frames, double max_median, TieEvidence& evidence) {
  const auto is_bad = [](const JudgedFrame& frame) { return !frame.sound; };
  while (std::any_of(frames.begin(), frames.end(), is_bad)) {
    std::vector<Candidate> candidates = scale_candidates(frames, max_median);
    for (const auto& hypothesis : pose_hypotheses())
      if (hypothesis.parts() > 0) candidates.push_back(pose_candidate(hypothesis, frames, max_median));
    const auto better = [](const Candidate& a, const Candidate& b) {
      if (a.bad != b.bad) return a.bad > b.bad;
      if (a.parts != b.parts) return a.parts < b.parts;
      return median(a.after) < median(b.after);
    };
    auto& best = *std::min_element(candidates.begin(), candidates.end(), better);
    if (best.bad == 0) break;
    best.verdict.before_px = median(best.before);
    best.verdict.after_px = median(best.after);
    const auto& explained = best.verdict.frames;
    std::erase_if(frames, [&](const JudgedFrame& judged) {
      return std::find(explained.begin(), explained.end(), judged.frame->id) != explained.end();
    });
    evidence.verdicts.push_back(std::move(best.verdict));
  }
  for (const auto& judged : frames)
    if (!judged.sound) evidence.unexplained.push_back(judged.frame->id);
}

// A shift of half a pixel in both axes, the same in (nearly) all frames.
std::optional<TieVerdict> half_pixel(const TieEvidence& evidence, const TieEvidenceOptions& options) {
  constexpr double kFrames = 0.8;  // of the judged frames must agree
  TieVerdict verdict;
  std::vector<double> dx, dy, before, after;
  std::size_t judged = 0, agreeing = 0;
  for (const auto& f : evidence.frames) {
    if (!f.judged || !(f.median_px <= options.max_median_px)) continue;
    ++judged;
    dx.push_back(f.bias_px.x());
    dy.push_back(f.bias_px.y());
    before.push_back(f.median_px);
    verdict.frames.push_back(f.frame);
  }
  if (judged == 0) return std::nullopt;
  const Vec2 shift(median(dx), median(dy));
  const double x = std::abs(shift.x()), y = std::abs(shift.y());
  if (std::abs(x - 0.5) > options.half_pixel_tolerance_px || std::abs(y - 0.5) > options.half_pixel_tolerance_px)
    return std::nullopt;
  for (std::size_t i = 0; i < judged; ++i)
    if (std::abs(dx[i] - shift.x()) < 2.0 * options.half_pixel_tolerance_px &&
        std::abs(dy[i] - shift.y()) < 2.0 * options.half_pixel_tolerance_px)
      ++agreeing;
  if (static_cast<double>(agreeing) < kFrames * static_cast<double>(judged)) return std::nullopt;
  verdict.code = "half_pixel_shift";
  verdict.before_px = median(before);
  verdict.meaning = "the observations lie " + base::to_fixed(shift.x(), 2) + ", " + base::to_fixed(shift.y(), 2) +
                    " px (x, y) from the projections in all frames: one side counts pixels from the first pixel's "
                    "centre, the other from its corner";
  verdict.remedy =
      "import again with the pixel origin of the source named (corner: the first pixel's centre is "
      "(0.5, 0.5))";
  return verdict;
}

}  // namespace

TieEvidence tie_evidence(const survey::Survey& survey, const TieEvidenceOptions& options) {
  auto checked = options;
  base::validate(base::bind_options(checked), "tie evidence");
  TieEvidence evidence;
  evidence.points = survey.ties.size();
  const auto seen_by_frame = collect(survey);
  std::vector<double> all;
  std::vector<JudgedFrame> frames;
  for (const auto& frame : survey.frames) {
    const auto it = seen_by_frame.find(frame.id);
    const auto* camera = survey.camera(frame.camera);
    if (it == seen_by_frame.end() || camera == nullptr || !frame.T_world_camera.translation.allFinite() ||
        !frame.T_world_camera.rotation.allFinite())
      continue;
    const auto& seen = it->second;
    evidence.observations += seen.size();
    evidence.frames.push_back(
        reprojection(frame, *camera, seen, static_cast<std::size_t>(options.min_observations), all));
    const auto& figures = evidence.frames.back();
    if (!figures.judged) continue;
    frames.push_back({&frame, camera, thinned(seen, static_cast<std::size_t>(options.max_observations)),
                      figures.median_px, figures.median_px <= options.max_median_px});
  }
  cover(std::move(frames), options.max_median_px, evidence);
  evidence.median_px = median(std::move(all));
  if (auto verdict = half_pixel(evidence, options)) {
    std::vector<double> after;
    for (const auto& f : evidence.frames) {
      if (std::find(verdict->frames.begin(), verdict->frames.end(), f.frame) == verdict->frames.end()) continue;
      const auto* frame = survey.frame(f.frame);
      after.push_back(
          median(errors(*survey.camera(frame->camera), frame->T_world_camera, seen_by_frame.at(f.frame), -f.bias_px)));
    }
    verdict->after_px = median(std::move(after));
    evidence.verdicts.push_back(std::move(*verdict));
  }
  return evidence;
}

}  // namespace cairn::adjustment
