#include "adjustment/tie_matches.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "adjustment/pair_matcher.hpp"
#include "adjustment/pose_hypotheses.hpp"
#include "adjustment/robust.hpp"
#include "adjustment/rough_alignment.hpp"
#include "adjustment/tracks.hpp"
#include "base/angle.hpp"
#include "base/parallel.hpp"

namespace cairn::adjustment {
namespace {

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

std::optional<double> ground_of(const PairEvidence& evidence) {
  std::vector<double> ups;
  for (const auto& pair : evidence.pairs)
    if (std::isfinite(pair.corrected_m)) ups.push_back(pair.plane_up_m);
  return ups.empty() ? std::optional<double>() : median(std::move(ups));
}

// Tracks of the matches as they stand, as nodes and as rays.
struct Joined {
  std::vector<std::vector<TrackNode>> nodes;
  std::vector<RayTrack> rays;
  std::size_t refused = 0;
};

Joined join(const PairMatcher& matcher) {
  std::vector<TrackEdge> edges;
  for (const auto& m : matcher.matched())
    for (const auto& c : m.consistent)
      edges.push_back({{static_cast<std::uint32_t>(m.frames.first), c.a},
                       {static_cast<std::uint32_t>(m.frames.second), c.b},
                       c.closeness});
  auto tracks = build_tracks(edges);
  Joined joined{std::move(tracks.tracks), {}, tracks.refused};
  for (const auto& nodes : joined.nodes) {
    RayTrack track;
    for (const auto& node : nodes) track.rays.push_back({node.image, matcher.view(node.image).rays[node.feature]});
    joined.rays.push_back(std::move(track));
  }
  return joined;
}

// Where the points may lie along each camera's axis: the middle 96 % of those it has, widened by a fifth each way; of
// all cameras' where it has few.
std::vector<GuidedView> guided_views(const PairMatcher& matcher, const std::vector<RoughCamera>& cameras,
                                     const Joined& joined) {
  std::vector<std::vector<double>> depths(cameras.size());
  std::vector<double> all;
  for (const auto& track : joined.rays) {
    if (!track.seen) continue;
    for (const auto& ray : track.rays) {
      const auto& T = cameras[ray.camera].T_world_camera;
      const double depth = T.rotation.col(2).dot(track.p_world - T.translation);
      depths[ray.camera].push_back(depth);
      all.push_back(depth);
    }
  }
  std::vector<GuidedView> views(cameras.size());
  constexpr std::size_t kEnough = 20;
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const auto& view = matcher.view(i);
    if (!view.usable || all.size() < kEnough) continue;
    auto& own = depths[i].size() < kEnough ? all : depths[i];
    std::sort(own.begin(), own.end());
    constexpr double kTail = 0.02, kWiden = 1.2;
    const auto last = static_cast<double>(own.size() - 1);
    views[i] = {view.camera,
                &view.features,
                &view.rays,
                cameras[i].T_world_camera,
                own[static_cast<std::size_t>(kTail * last)] / kWiden,
                own[static_cast<std::size_t>((1.0 - kTail) * last)] * kWiden};
  }
  return views;
}

}  // namespace

MatchedTies match_ties(const survey::Survey& rough, const ImageLoader& load, const TieMatchOptions& options,
                       base::RunContext& ctx) {
  auto checked = options;
  base::validate(base::bind_options(checked), "feature matching");
  MatchedTies result;
  result.frames = rough.frames;
  const std::size_t n = rough.frames.size();

  PairMatcher matcher(rough, options, ctx);
  matcher.find_features(load);
  for (std::size_t i = 0; i < n; ++i) {
    if (matcher.view(i).reject) result.rejects.push_back(*matcher.view(i).reject);
    result.features += matcher.view(i).features.size();
  }
  // The nearest pairs tell the height of the ground, and so which of the others can share any of it.
  matcher.match(neighbour_pairs(rough));
  const auto first_ground = ground_of(matcher.evidence());
  auto pairs = candidates(rough, options);
  std::erase_if(pairs, [&](const IndexPair& p) {
    const auto &a = matcher.view(p.first), &b = matcher.view(p.second);
    if (!a.usable || !b.usable) return true;
    constexpr double kLeastShare = 0.1;
    return first_ground && shared_view(rough.frames[p.first], *a.camera, rough.frames[p.second], *b.camera,
                                       *first_ground, options.position_slack_m) < kLeastShare;
  });
  matcher.match(pairs);
  const auto evidence = matcher.evidence();
  if (options.turn_frames) put_right(evidence, rough, result);
  const auto ground = ground_of(evidence);
  result.ground_known = ground.has_value();
  result.ground_up_m = ground.value_or(0.0);

  auto joined = join(matcher);
  auto cameras = rough_cameras(result.frames);
  const double least_sine = std::sin(base::deg_to_rad(options.min_angle_deg));
  RoughAlignmentOptions alignment;
  alignment.least_sine = least_sine;
  double middle = align_roughly(cameras, joined.rays, ground, alignment);
  if (options.guided && std::isfinite(middle)) {
    matcher.match_guided(pairs, guided_views(matcher, cameras, joined));
    joined = join(matcher);
    middle = align_roughly(cameras, joined.rays, std::nullopt, alignment);
  }
  result.start = result.frames;
  for (std::size_t i = 0; i < n; ++i) result.start[i].T_world_camera = cameras[i].T_world_camera;
  for (const auto& m : matcher.matched()) result.pairs.push_back(m.report);

  constexpr double kGateOfMedian = 6.0;
  const double gate = std::max(options.max_residual, kGateOfMedian * middle);
  std::map<std::string, std::size_t> lost;
  std::vector<bool> tied(n, false);
  std::vector<double> residuals;
  for (std::size_t t = 0; t < joined.rays.size(); ++t) {
    auto& nodes = joined.nodes[t];
    const auto why =
        settle(joined.rays[t], nodes, cameras, gate, least_sine, static_cast<std::size_t>(options.min_track));
    if (!why.empty()) {
      ++lost[why];
      continue;
    }
    survey::TiePoint tie;
    tie.id = survey::TiePointId(static_cast<std::int64_t>(result.ties.size()) + 1);
    tie.p_world = joined.rays[t].p_world;
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      const auto& view = matcher.view(nodes[i].image);
      tie.observations.push_back({rough.frames[nodes[i].image].id, view.features.pixels[nodes[i].feature]});
      tied[nodes[i].image] = true;
      residuals.push_back(ray_residual(joined.rays[t].rays[i], cameras[nodes[i].image], tie.p_world) *
                          view.camera->fx_px);
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
