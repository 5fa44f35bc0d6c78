#include "pipeline/check_evidence.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "adjustment/robust.hpp"
#include "base/number_text.hpp"
#include "base/parallel.hpp"
#include "io/image.hpp"

namespace cairn::pipeline {
namespace fs = std::filesystem;
namespace {

using base::to_fixed;
using io::Json;

std::string short_name(const survey::Frame& frame) {
  const std::string stem = fs::path(frame.image).stem().string();
  return stem.empty() ? "frame " + std::to_string(frame.id.value) : stem;
}

Json ids_of(const std::vector<survey::FrameId>& frames) {
  Json list = Json::array();
  for (const auto id : frames) list.push(id.value);
  return list;
}

std::string metres(double value) {
  return std::isfinite(value) ? to_fixed(value, 2) + " m" : "no common ground";
}

std::string pixels(double value) {
  return std::isfinite(value) ? to_fixed(value, 2) + " px" : "points behind the camera";
}

// One finding a frame where only some are concerned (each has to be treated), one in all where the whole
// survey shares the mistake.
void add_verdict(const CheckedSurvey& checked, const fs::path& folder, const std::string& code,
                 const std::vector<survey::FrameId>& frames, const std::string& meaning, const std::string& before,
                 const std::string& after, const std::string& allowed, std::string hint, Findings& findings) {
  const std::string file = (folder / "frames.csv").string();
  const bool turned = code.rfind("frame_turned_", 0) == 0;
  if (code == "frame_turned_180") hint = "import again with --rotate " + frame_ranges(checked.survey, frames);
  const std::string message = told(meaning, before + " as declared, " + after + " when it is undone", allowed);
  if (!turned && frames.size() == checked.survey.frames.size()) {
    findings.add({code, Severity::error, file, "all " + std::to_string(frames.size()) + " frames", message, hint});
    return;
  }
  for (const auto id : frames) findings.add({code, Severity::error, file, checked.frame_records.at(id), message, hint});
}

// At most `most` frames with images: all, or runs of ten neighbours spread over the survey.
std::vector<survey::FrameId> chosen(const CheckedSurvey& checked, const std::map<survey::FrameId, fs::path>& images,
                                    std::size_t most) {
  std::vector<survey::FrameId> all;
  for (const auto& frame : checked.survey.frames)
    if (images.contains(frame.id)) all.push_back(frame.id);
  if (all.size() <= most) return all;
  constexpr std::size_t kRun = 10;
  const std::size_t runs = std::max<std::size_t>(1, most / kRun);
  std::vector<survey::FrameId> some;
  for (std::size_t run = 0; run < runs; ++run) {
    const std::size_t first = run * all.size() / runs;
    for (std::size_t i = first; i < std::min(first + kRun, (run + 1) * all.size() / runs); ++i) some.push_back(all[i]);
  }
  return some;
}

struct LoadedImages {
  std::vector<survey::FrameId> frames;
  std::vector<geometry::GreyImage> images;
};

LoadedImages load(const CheckedSurvey& checked, const std::map<survey::FrameId, fs::path>& files,
                  const CheckOptions& options, std::int64_t max_width, base::RunContext& ctx, Findings& findings) {
  const auto wanted = chosen(checked, files, static_cast<std::size_t>(options.max_images));
  std::vector<geometry::GreyImage> images(wanted.size());
  std::vector<std::optional<base::Error>> errors(wanted.size());
  base::parallel_for(wanted.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      ctx.check_stop();
      try {
        images[i] = io::read_grey_image(files.at(wanted[i]), max_width);
      } catch (base::Error& error) {
        errors[i] = error;
      }
    }
  });
  LoadedImages loaded;
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    if (errors[i]) {
      const std::string record = "frames.csv, " + checked.frame_records.at(wanted[i]);
      if (!findings.has("image_unreadable")) findings.add("image_unreadable", *errors[i], record);
      continue;
    }
    loaded.frames.push_back(wanted[i]);
    loaded.images.push_back(std::move(images[i]));
  }
  return loaded;
}

}  // namespace

std::string frame_ranges(const survey::Survey& survey, const std::vector<survey::FrameId>& frames) {
  std::string text;
  for (std::size_t i = 0; i < survey.frames.size();) {
    const auto is_in = [&](std::size_t k) {
      return k < survey.frames.size() && std::find(frames.begin(), frames.end(), survey.frames[k].id) != frames.end();
    };
    if (!is_in(i)) {
      ++i;
      continue;
    }
    std::size_t last = i;
    while (is_in(last + 1)) ++last;
    text += (text.empty() ? "" : ",") + short_name(survey.frames[i]);
    if (last > i) text += "-" + short_name(survey.frames[last]);
    i = last + 1;
  }
  return text;
}

bool check_ties(const CheckedSurvey& checked, const fs::path& folder, const CheckOptions& options, Findings& findings,
                Json& evidence) {
  if (checked.survey.ties.empty()) {
    findings.add({"no_tie_points", Severity::info, (folder / "tie_points.csv").string(), "",
                  "the survey has no tie points: its poses are proved by matching images only",
                  "Import a reconstruction (COLMAP, OpenSfM) to have poses proved to the pixel"});
    return false;
  }
  const auto ties = adjustment::tie_evidence(checked.survey, options.ties);
  Json frames = Json::array();
  std::size_t good = 0;
  for (const auto& f : ties.frames) {
    if (f.judged && f.median_px <= options.ties.max_median_px) ++good;
    frames.push(Json::object({{"frame_id", f.frame.value},
                              {"observations", f.observations},
                              {"behind", f.behind},
                              {"median_px", f.median_px},
                              {"bias_x_px", f.bias_px.x()},
                              {"bias_y_px", f.bias_px.y()}}));
  }
  Json verdicts = Json::array();
  for (const auto& v : ties.verdicts) {
    verdicts.push(Json::object({{"code", v.code},
                                {"frames", ids_of(v.frames)},
                                {"before_px", v.before_px},
                                {"after_px", v.after_px},
                                {"meaning", v.meaning}}));
    add_verdict(checked, folder, v.code, v.frames, v.meaning, "a median reprojection error of " + pixels(v.before_px),
                pixels(v.after_px),
                v.code == "half_pixel_shift" ? "no constant shift"
                                             : "at most " + to_fixed(options.ties.max_median_px, 1) + " px",
                v.remedy, findings);
  }
  for (const auto id : ties.unexplained) {
    const auto it = std::find_if(ties.frames.begin(), ties.frames.end(), [&](const auto& f) { return f.frame == id; });
    findings.add(
        {"reprojection_error", Severity::error, (folder / "frames.csv").string(), checked.frame_records.at(id),
         told("the tie points do not reproject, and no known misreading explains it",
              "a median of " + pixels(it->median_px), "at most " + to_fixed(options.ties.max_median_px, 1) + " px"),
         "Check this frame's pose and camera; cairn refine adjusts poses that are nearly right"});
  }
  evidence.set("tie_points_reprojection", Json::object({{"points", ties.points},
                                                        {"observations", ties.observations},
                                                        {"median_px", ties.median_px},
                                                        {"frames", std::move(frames)},
                                                        {"verdicts", std::move(verdicts)}}));
  constexpr double kProved = 0.9;
  return static_cast<double>(good) >= kProved * static_cast<double>(checked.survey.frames.size());
}

void check_pairs(const CheckedSurvey& checked, const fs::path& folder,
                 const std::map<survey::FrameId, fs::path>& images, const CheckOptions& options, base::RunContext& ctx,
                 Findings& findings, Json& evidence, std::map<survey::FrameId, double>& ground) {
  // Decoding may stop at the next fraction above the width that matching shrinks to.
  const auto loaded = load(checked, images, options, 2 * options.matches.max_width_px, ctx, findings);
  if (loaded.frames.size() < 2) return;
  ctx.check_stop();
  survey::Survey part = checked.survey;
  std::erase_if(part.frames, [&](const survey::Frame& f) {
    return !std::binary_search(loaded.frames.begin(), loaded.frames.end(), f.id);
  });
  const auto pairs = adjustment::neighbour_pairs(part, options.pairs);
  const auto matches = adjustment::match_images(loaded.images, pairs, options.matches);
  std::vector<adjustment::MatchedPair> matched;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const auto [a, b] = pairs[i];
    adjustment::MatchedPair pair{part.frames[a].id, part.frames[b].id, matches[i]};
    const auto factor = [&](std::size_t frame) {
      return static_cast<double>(part.camera(part.frames[frame].camera)->width_px) /
             static_cast<double>(loaded.images[frame].width_px);
    };
    for (auto& match : pair.matches) {
      match.a *= factor(a);
      match.b *= factor(b);
    }
    if (!pair.matches.empty()) matched.push_back(std::move(pair));
  }
  const auto found = adjustment::pair_evidence(part, matched, options.pairs);
  Json list = Json::array();
  std::map<survey::FrameId, std::vector<double>> planes;
  for (const auto& p : found.pairs) {
    list.push(Json::object({{"a", p.a.value},
                            {"b", p.b.value},
                            {"matches", p.matches},
                            {"baseline_m", p.baseline_m},
                            {"disagreement_m", p.declared_m},
                            {"disagreement_corrected_m", p.corrected_m},
                            {"ground_up_m", p.plane_up_m},
                            {"turn_deg", p.turn_deg}}));
    if (!std::isfinite(p.corrected_m)) continue;
    planes[p.a].push_back(p.plane_up_m);
    planes[p.b].push_back(p.plane_up_m);
  }
  if (ground.empty())
    for (auto& [id, heights] : planes) ground[id] = adjustment::median(std::move(heights));
  Json verdicts = Json::array();
  for (const auto& v : found.verdicts) {
    verdicts.push(Json::object({{"code", v.code},
                                {"frames", ids_of(v.frames)},
                                {"before_m", v.before_m},
                                {"after_m", v.after_m},
                                {"meaning", v.meaning}}));
    add_verdict(checked, folder, v.code, v.frames, v.meaning,
                "neighbouring images disagree by " + metres(v.before_m) + " on the ground", metres(v.after_m),
                "at most " + to_fixed(options.pairs.max_sound_ratio, 2) + " of the base line", v.remedy, findings);
  }
  for (const auto id : found.unexplained)
    findings.add({"pairs_disagree", Severity::warning, (folder / "frames.csv").string(), checked.frame_records.at(id),
                  "the image does not show the ground where its pose says, against its neighbours, and no known "
                  "misreading explains it",
                  "Check this frame's position and attitude"});
  if (!found.unmatched.empty())
    findings.add({"pairs_unmatched", Severity::info, (folder / "frames.csv").string(),
                  frame_ranges(checked.survey, found.unmatched),
                  std::to_string(found.unmatched.size()) + " frames could not be matched with a neighbour: their poses "
                                                           "are not proved",
                  ""});
  std::vector<double> corrected;
  for (const auto& p : found.pairs) corrected.push_back(p.corrected_m);
  evidence.set("image_pairs", Json::object({{"used", found.pairs.size()},
                                            {"median_disagreement_corrected_m", adjustment::median(corrected)},
                                            {"pairs", std::move(list)},
                                            {"verdicts", std::move(verdicts)},
                                            {"unmatched", ids_of(found.unmatched)}}));
}

void check_cloud_evidence(const CheckedSurvey& checked, const CheckedCloud& cloud,
                          const std::map<survey::FrameId, fs::path>& images, const CheckOptions& options,
                          base::RunContext& ctx, Findings& findings, Json& evidence) {
  const auto surface = adjustment::cloud_surface(cloud.cloud);
  LoadedImages loaded;
  constexpr std::int64_t kEnoughWidth = 2000;  // px: a cloud's cell is rarely finer than such an image's pixel
  if (options.pixels && surface.coloured) loaded = load(checked, images, options, kEnoughWidth, ctx, findings);
  std::vector<adjustment::FrameImage> frame_images;
  for (std::size_t i = 0; i < loaded.frames.size(); ++i) frame_images.push_back({loaded.frames[i], &loaded.images[i]});
  ctx.check_stop();
  const auto found = adjustment::cloud_evidence(checked.survey, frame_images, surface, options.cloud);
  Json json = Json::object({{"places", found.places},
                            {"places_tried", found.places_tried},
                            {"comparisons", found.matches.size()},
                            {"mean_correlation", found.mean_correlation},
                            {"cell_m", surface.up_m.geometry.cell},
                            {"similarity_declared", cloud.has_similarity}});
  std::string text;
  double significant = 0.0;
  // A frame's pose error moves all its comparisons alike: the frames are what can be counted.
  std::set<survey::FrameId> seen_by;
  for (const auto& match : found.matches) seen_by.insert(match.frame);
  const auto independent = std::max<std::size_t>(1, std::min(found.places, seen_by.size()));
  // The part of an offset that three standard errors of the median leave.
  const auto beyond = [](double offset, double scatter, std::size_t count) {
    constexpr double kSigmas = 3.0;
    return std::abs(offset) - kSigmas * scatter / std::sqrt(static_cast<double>(std::max<std::size_t>(1, count)));
  };
  // Poses that scatter by a good part of the search cut the shifts off at its border: no figure.
  constexpr double kMostScatter = 0.25;  // of the search, each way
  const bool determined =
      found.horizontal_m && found.horizontal_scatter_m.norm() <= kMostScatter * options.cloud.search_m;
  json.set("horizontal_determined", determined);
  if (found.horizontal_m) {
    const auto& h = *found.horizontal_m;
    const auto& s = found.horizontal_scatter_m;
    json.set("east_m", h.x()).set("north_m", h.y()).set("scatter_east_m", s.x()).set("scatter_north_m", s.y());
    text = to_fixed(h.x(), 2) + " m east, " + to_fixed(h.y(), 2) + " m north (scatter " + to_fixed(s.norm(), 2) +
           " m over " + std::to_string(found.places) + " places)";
    if (determined)
      significant = std::max({significant, beyond(h.x(), s.x(), independent), beyond(h.y(), s.y(), independent)});
  }
  if (found.vertical_m) {
    json.set("up_m", *found.vertical_m).set("scatter_up_m", found.vertical_scatter_m).set("up_by", found.vertical_by);
    json.set("tie_points", found.tie_points).set("height_slope", found.height_slope);
    const bool by_ties = found.vertical_by == "tie_points";
    text += (text.empty() ? "" : ", ") + to_fixed(*found.vertical_m, 2) + " m up (scatter " +
            to_fixed(found.vertical_scatter_m, 2) + " m, by " +
            (by_ties ? std::to_string(found.tie_points) + " tie points" : "parallax") + ")";
    if (by_ties || determined)
      significant = std::max(
          significant, beyond(*found.vertical_m, found.vertical_scatter_m, by_ties ? found.tie_points : independent));
  }
  evidence.set("cloud_offset", std::move(json));
  if (significant <= options.max_cloud_offset_m) return;
  findings.add({"cloud_offset", Severity::warning, cloud.path.string(), "source 'cloud' of survey.json",
                told(cloud.has_similarity ? "the declared similarity leaves the cloud beside the poses"
                                          : "the cloud does not share the poses' frame: cloud minus poses",
                     text, "at most " + to_fixed(options.max_cloud_offset_m, 2) + " m"),
                "Import again with --similarity FILE (T_world_source of the cloud), or bring the poses to the ground's "
                "true place with cairn refine --control FILE"});
}

}  // namespace cairn::pipeline
