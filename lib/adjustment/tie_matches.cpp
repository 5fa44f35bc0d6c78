#include "adjustment/tie_matches.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <map>
#include <optional>
#include <set>

#include "adjustment/evidence_pairs.hpp"
#include "adjustment/image_features.hpp"
#include "adjustment/pose_hypotheses.hpp"
#include "adjustment/robust.hpp"
#include "adjustment/rough_alignment.hpp"
#include "adjustment/tracks.hpp"
#include "base/angle.hpp"
#include "base/error.hpp"
#include "base/parallel.hpp"
#include "camera/projection.hpp"

namespace cairn::adjustment {
namespace {

using geometry::Vec2;
using geometry::Vec3;
using IndexPair = std::pair<std::size_t, std::size_t>;

constexpr double kLeastCosine = 0.26;  // of a ray with the optical axis: 75 degrees

// What is kept of an image: its features as pixels of the frame's camera and as rays.
struct View {
  const survey::Camera* camera = nullptr;
  bool usable = false;
  ImageFeatures features;
  std::vector<Vec2> rays;  // on the plane z = 1
  std::optional<base::Reject> reject;
};

struct Matched {
  IndexPair frames;
  std::vector<FeaturePair> consistent;
  TiePair report;
};

std::string name_of_frame(const survey::Frame& frame) {
  return "frame " + std::to_string(frame.id.value);
}

// Features far outside the field that rays describe are dropped.
void keep_rays(View& view) {
  const double sx = static_cast<double>(view.camera->width_px) / view.features.width_px;
  const double sy = static_cast<double>(view.camera->height_px) / view.features.height_px;
  ImageFeatures kept;
  kept.width_px = view.features.width_px;
  kept.height_px = view.features.height_px;
  for (std::size_t i = 0; i < view.features.size(); ++i) {
    const Vec2 pixel(view.features.pixels[i].x() * sx, view.features.pixels[i].y() * sy);
    const auto ray = camera::unproject(*view.camera, pixel);
    if (!ray || !(ray->z() > kLeastCosine)) continue;
    kept.pixels.push_back(pixel);
    const auto* from = view.features.descriptors.data() + i * kDescriptorBytes;
    kept.descriptors.insert(kept.descriptors.end(), from, from + kDescriptorBytes);
    view.rays.emplace_back(ray->head<2>() / ray->z());
  }
  view.features = std::move(kept);
}

View view_of(const survey::Survey& survey, const survey::Frame& frame, const ImageLoader& load,
             const TieMatchOptions& options) {
  View view;
  view.camera = survey.camera(frame.camera);
  const auto reject = [&](const char* reason, std::string message) {
    view.reject = base::Reject{name_of_frame(frame), reason, std::move(message)};
    return view;
  };
  if (frame.image.empty()) return reject("no_image", "the frame has no image");
  if (view.camera == nullptr) return reject("unknown_camera", "the frame's camera is not in the survey");
  geometry::GreyImage image;
  try {
    image = load(frame);
  } catch (const base::Error& error) {
    if (error.code() == base::ErrorCode::cancelled) throw;
    return reject("image_unreadable", error.what());
  }
  const double sx = static_cast<double>(view.camera->width_px) / static_cast<double>(image.width_px);
  const double sy = static_cast<double>(view.camera->height_px) / static_cast<double>(image.height_px);
  constexpr double kProportion = 0.01;  // a pixel lost in a reduction of a small image
  if (image.values.empty() || !(std::abs(sx / sy - 1.0) < kProportion))
    return reject("image_size", "the image (" + std::to_string(image.width_px) + " x " +
                                    std::to_string(image.height_px) + " px) has not the proportions of its camera (" +
                                    std::to_string(view.camera->width_px) + " x " +
                                    std::to_string(view.camera->height_px) + " px)");
  view.features = image_features(image, options.max_width_px, options.max_features, true);
  keep_rays(view);
  view.usable = true;
  return view;
}

// Share of a's view of the level ground that b, its image widened by slack_m of ground, sees too.
double shared_view(const survey::Frame& a, const survey::Camera& camera_a, const survey::Frame& b,
                   const survey::Camera& camera_b, double ground_up, double slack_m) {
  constexpr int kSide = 8;
  int hits = 0, seen = 0;
  const double height = b.T_world_camera.translation.z() - ground_up;
  if (!(height > 0.0)) return 1.0;
  const double margin_x = slack_m / height * camera_b.fx_px, margin_y = slack_m / height * camera_b.fy_px;
  for (int i = 0; i < kSide; ++i)
    for (int j = 0; j < kSide; ++j) {
      const Vec2 pixel((i + 0.5) / kSide * static_cast<double>(camera_a.width_px),
                       (j + 0.5) / kSide * static_cast<double>(camera_a.height_px));
      const auto ray = camera::pixel_ray(camera_a, a.T_world_camera, pixel);
      if (!ray || !(ray->direction.z() < 0.0)) continue;
      ++hits;
      const Vec3 ground = ray->origin + (ground_up - ray->origin.z()) / ray->direction.z() * ray->direction;
      const auto at = camera::project_world(camera_b, b.T_world_camera, ground);
      if (at && at->x() > -margin_x && at->y() > -margin_y &&
          at->x() < static_cast<double>(camera_b.width_px) + margin_x &&
          at->y() < static_cast<double>(camera_b.height_px) + margin_y)
        ++seen;
    }
  return hits == 0 ? 1.0 : static_cast<double>(seen) / hits;
}

class Matcher {
 public:
  Matcher(const survey::Survey& rough, const TieMatchOptions& options, base::RunContext& ctx)
      : rough_(rough), options_(options), ctx_(ctx), views_(rough.frames.size()) {}

  void find_features(const ImageLoader& load) {
    const std::size_t n = rough_.frames.size();
    ctx_.check_memory(n * static_cast<std::size_t>(options_.max_features) * (kDescriptorBytes + 2 * sizeof(Vec2)),
                      "features of the images");
    std::atomic<std::size_t> done{0};
    base::parallel_for(n, 1, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        ctx_.check_stop();
        views_[i] = view_of(rough_, rough_.frames[i], load, options_);
        ctx_.progress("images", ++done, n);
      }
    });
  }

  [[nodiscard]] const View& view(std::size_t i) const { return views_[i]; }

  // Index pairs not matched yet, ascending; each is matched once.
  void match(std::vector<IndexPair> pairs) {
    std::sort(pairs.begin(), pairs.end());
    pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
    std::erase_if(pairs, [&](const IndexPair& p) {
      return tried_.contains(p) || !views_[p.first].usable || !views_[p.second].usable;
    });
    tried_.insert(pairs.begin(), pairs.end());
    std::vector<Matched> results(pairs.size());
    base::parallel_for(pairs.size(), 1, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        ctx_.check_stop();
        results[i] = match_pair(pairs[i]);
      }
    });
    for (auto& result : results) matched_.push_back(std::move(result));
    std::sort(matched_.begin(), matched_.end(), [](const Matched& x, const Matched& y) { return x.frames < y.frames; });
  }

  [[nodiscard]] const std::vector<Matched>& matched() const { return matched_; }

  [[nodiscard]] PairEvidence evidence() const {
    std::vector<MatchedPair> pairs;
    for (const auto& m : matched_) {
      if (m.consistent.empty()) continue;
      MatchedPair pair{m.report.a, m.report.b, {}};
      for (const auto& c : m.consistent)
        pair.matches.push_back(
            {views_[m.frames.first].features.pixels[c.a], views_[m.frames.second].features.pixels[c.b]});
      pairs.push_back(std::move(pair));
    }
    return pair_evidence(rough_, pairs);
  }

 private:
  [[nodiscard]] Matched match_pair(const IndexPair& frames) const {
    const View &a = views_[frames.first], &b = views_[frames.second];
    Matched result;
    result.frames = frames;
    result.report.a = rough_.frames[frames.first].id;
    result.report.b = rough_.frames[frames.second].id;
    const auto paired = pair_features(a.features, b.features, options_.ratio);
    result.report.matched = paired.size();
    if (paired.size() < static_cast<std::size_t>(options_.min_inliers)) {
      result.report.reason = "too_few_matches";
      return result;
    }
    std::vector<RayMatch> rays;
    for (const auto& pair : paired) rays.push_back({a.rays[pair.a], b.rays[pair.b]});
    TwoViewOptions two_view;
    two_view.epipolar = options_.epipolar;
    two_view.min_inliers = static_cast<std::size_t>(options_.min_inliers);
    const auto verified = verify_two_views(rays, two_view);
    result.report.model = verified.model;
    result.report.consistent = verified.inliers;
    if (verified.model == TwoViewModel::none) result.report.reason = "inconsistent";
    for (std::size_t i = 0; i < paired.size(); ++i)
      if (verified.inlier[i] != 0) result.consistent.push_back(paired[i]);
    return result;
  }

  const survey::Survey& rough_;
  const TieMatchOptions& options_;
  base::RunContext& ctx_;
  std::vector<View> views_;
  std::set<IndexPair> tried_;
  std::vector<Matched> matched_;
};

std::vector<IndexPair> candidates(const survey::Survey& rough, const TieMatchOptions& options) {
  const std::size_t n = rough.frames.size();
  std::vector<IndexPair> pairs;
  if (n <= static_cast<std::size_t>(options.all_pairs_up_to)) {
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = i + 1; j < n; ++j) pairs.emplace_back(i, j);
    return pairs;
  }
  PairEvidenceOptions near;
  near.neighbours = options.neighbours;
  near.min_baseline_m = 0.0;
  pairs = neighbour_pairs(rough, near);
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t k = 1; k <= static_cast<std::size_t>(options.successors) && i + k < n; ++k)
      pairs.emplace_back(i, i + k);
  return pairs;
}

// The turns that pair_evidence found, applied.
void put_right(const PairEvidence& evidence, const survey::Survey& rough, MatchedTies& result) {
  for (const auto& verdict : evidence.verdicts) {
    int deg = 0;
    for (const int turn : {90, 180, 270})
      if (verdict.code == "frame_turned_" + std::to_string(turn)) deg = turn;
    if (deg == 0) continue;
    PoseHypothesis hypothesis;
    hypothesis.turned_deg = deg;
    for (const auto id : verdict.frames) {
      TurnedFrame turned{id, deg, 0.0, 0.0, 0};
      std::vector<double> before, after;
      for (const auto& pair : evidence.pairs)
        if (pair.a == id || pair.b == id) {
          before.push_back(pair.declared_m);
          after.push_back(pair.corrected_m);
        }
      turned.pairs = before.size();
      turned.before_m = median(std::move(before));
      turned.after_m = median(std::move(after));
      result.turned.push_back(turned);
      auto& frame = result.frames[static_cast<std::size_t>(rough.frame(id) - rough.frames.data())];
      frame.T_world_camera = hypothesis.apply(frame.T_world_camera);
    }
  }
  std::sort(result.turned.begin(), result.turned.end(),
            [](const TurnedFrame& x, const TurnedFrame& y) { return x.frame < y.frame; });
}

std::vector<RoughCamera> rough_cameras(const std::vector<survey::Frame>& frames) {
  std::vector<RoughCamera> cameras;
  for (const auto& frame : frames) {
    RoughCamera camera;
    camera.T_world_camera = frame.T_world_camera;
    if (frame.sigma_xy_m > 0.0) camera.sigma_xy_m = frame.sigma_xy_m;
    if (frame.sigma_z_m > 0.0) camera.sigma_z_m = frame.sigma_z_m;
    if (frame.sigma_rot_deg > 0.0) camera.sigma_rot_deg = frame.sigma_rot_deg;
    cameras.push_back(camera);
  }
  return cameras;
}

// Drops the worst observations one by one until the rest agree. The reason why the track is lost, or "".
std::string settle(RayTrack& track, std::vector<TrackNode>& nodes, const std::vector<RoughCamera>& cameras, double gate,
                   double least_sine, std::size_t least) {
  while (true) {
    if (track.rays.size() < least) return "residual";
    const auto p = intersect_rays(track.rays, cameras, least_sine);
    if (!p) return "angle_or_behind";
    track.p_world = *p;
    std::size_t worst = 0;
    double most = -1.0;
    for (std::size_t i = 0; i < track.rays.size(); ++i) {
      const double residual = ray_residual(track.rays[i], cameras[track.rays[i].camera], *p);
      if (residual > most) {
        most = residual;
        worst = i;
      }
    }
    if (most <= gate) return "";
    track.rays.erase(track.rays.begin() + static_cast<std::ptrdiff_t>(worst));
    nodes.erase(nodes.begin() + static_cast<std::ptrdiff_t>(worst));
  }
}

}  // namespace

MatchedTies match_ties(const survey::Survey& rough, const ImageLoader& load, const TieMatchOptions& options,
                       base::RunContext& ctx) {
  auto checked = options;
  base::validate(base::bind_options(checked), "feature matching");
  MatchedTies result;
  result.frames = rough.frames;
  const std::size_t n = rough.frames.size();

  Matcher matcher(rough, options, ctx);
  matcher.find_features(load);
  for (std::size_t i = 0; i < n; ++i) {
    if (matcher.view(i).reject) result.rejects.push_back(*matcher.view(i).reject);
    result.features += matcher.view(i).features.size();
  }
  // The nearest pairs tell the height of the ground, and so which of the others can share any of it.
  matcher.match(neighbour_pairs(rough));
  auto evidence = matcher.evidence();
  const auto ground_of = [](const PairEvidence& e) {
    std::vector<double> ups;
    for (const auto& pair : e.pairs)
      if (std::isfinite(pair.corrected_m)) ups.push_back(pair.plane_up_m);
    return ups.empty() ? std::optional<double>() : median(std::move(ups));
  };
  auto ground = ground_of(evidence);
  auto pairs = candidates(rough, options);
  if (ground)
    std::erase_if(pairs, [&](const IndexPair& p) {
      const auto &a = rough.frames[p.first], &b = rough.frames[p.second];
      if (!matcher.view(p.first).usable || !matcher.view(p.second).usable) return true;
      constexpr double kLeastShare = 0.1;
      return shared_view(a, *matcher.view(p.first).camera, b, *matcher.view(p.second).camera, *ground,
                         options.position_slack_m) < kLeastShare;
    });
  matcher.match(std::move(pairs));
  evidence = matcher.evidence();
  if (options.turn_frames) put_right(evidence, rough, result);
  ground = ground_of(evidence);
  result.ground_known = ground.has_value();
  result.ground_up_m = ground.value_or(0.0);

  std::vector<TrackEdge> edges;
  for (const auto& m : matcher.matched()) {
    result.pairs.push_back(m.report);
    for (const auto& c : m.consistent)
      edges.push_back({{static_cast<std::uint32_t>(m.frames.first), c.a},
                       {static_cast<std::uint32_t>(m.frames.second), c.b},
                       c.closeness});
  }
  auto joined = build_tracks(edges);
  std::vector<RayTrack> tracks;
  for (const auto& nodes : joined.tracks) {
    RayTrack track;
    for (const auto& node : nodes) track.rays.push_back({node.image, matcher.view(node.image).rays[node.feature]});
    tracks.push_back(std::move(track));
  }
  auto cameras = rough_cameras(result.frames);
  const double least_sine = std::sin(base::deg_to_rad(options.min_angle_deg));
  RoughAlignmentOptions alignment;
  alignment.least_sine = least_sine;
  const double middle = align_roughly(cameras, tracks, ground, alignment);
  result.start = result.frames;
  for (std::size_t i = 0; i < n; ++i) result.start[i].T_world_camera = cameras[i].T_world_camera;

  constexpr double kGateOfMedian = 6.0;
  const double gate = std::max(options.max_residual, kGateOfMedian * middle);
  std::map<std::string, std::size_t> lost;
  std::vector<bool> tied(n, false);
  std::vector<double> residuals;
  for (std::size_t t = 0; t < tracks.size(); ++t) {
    auto& nodes = joined.tracks[t];
    const auto why = settle(tracks[t], nodes, cameras, gate, least_sine, static_cast<std::size_t>(options.min_track));
    if (!why.empty()) {
      ++lost[why];
      continue;
    }
    survey::TiePoint tie;
    tie.id = survey::TiePointId(static_cast<std::int64_t>(result.ties.size()) + 1);
    tie.p_world = tracks[t].p_world;
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      const auto& view = matcher.view(nodes[i].image);
      tie.observations.push_back({rough.frames[nodes[i].image].id, view.features.pixels[nodes[i].feature]});
      tied[nodes[i].image] = true;
      residuals.push_back(ray_residual(tracks[t].rays[i], cameras[nodes[i].image], tie.p_world) * view.camera->fx_px);
    }
    result.observations += tie.observations.size();
    result.ties.push_back(std::move(tie));
  }
  result.median_residual_px = residuals.empty() ? 0.0 : median(std::move(residuals));
  for (std::size_t i = 0; i < n; ++i)
    if (!tied[i]) result.unmatched.push_back(rough.frames[i].id);
  if (joined.refused > 0) lost["conflict"] = joined.refused;
  for (const auto& [reason, count] : lost) {
    const std::string what = reason == "conflict"   ? " matches would have joined two features of one image"
                             : reason == "residual" ? " tracks did not agree on one point in enough images"
                                                    : " tracks had nearly parallel rays or lay behind a camera";
    result.rejects.push_back({"ties", reason, std::to_string(count) + what});
  }
  return result;
}

}  // namespace cairn::adjustment
