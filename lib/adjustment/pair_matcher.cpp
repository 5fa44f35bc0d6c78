#include "adjustment/pair_matcher.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>

#include "base/error.hpp"
#include "base/parallel.hpp"
#include "camera/projection.hpp"

namespace cairn::adjustment {
namespace {

using geometry::Vec2;
using geometry::Vec3;

constexpr double kLeastCosine = 0.26;  // of a ray with the optical axis: 75 degrees

std::string name_of_frame(const survey::Frame& frame) {
  return "frame " + std::to_string(frame.id.value);
}

// Features far outside the field that rays describe are dropped.
void keep_rays(ImageView& view) {
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

ImageView view_of(const survey::Survey& survey, const survey::Frame& frame, const ImageLoader& load,
                  const TieMatchOptions& options) {
  ImageView view;
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

}  // namespace

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

PairMatcher::PairMatcher(const survey::Survey& rough, const TieMatchOptions& options, base::RunContext& ctx)
    : rough_(rough), options_(options), ctx_(ctx), views_(rough.frames.size()) {}

void PairMatcher::find_features(const ImageLoader& load) {
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

void PairMatcher::match(std::vector<IndexPair> pairs) {
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  std::erase_if(pairs, [&](const IndexPair& p) {
    return tried_.contains(p) || !views_[p.first].usable || !views_[p.second].usable;
  });
  tried_.insert(pairs.begin(), pairs.end());
  std::vector<ImagePair> results(pairs.size());
  std::atomic<std::size_t> done{0};
  base::parallel_for(pairs.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      ctx_.check_stop();
      results[i] = verified(pairs[i], pair_features(views_[pairs[i].first].features, views_[pairs[i].second].features,
                                                    options_.ratio, static_cast<std::size_t>(options_.first_features)));
      ctx_.progress("image pairs", ++done, pairs.size());
    }
  });
  for (auto& result : results) matched_.push_back(std::move(result));
  std::sort(matched_.begin(), matched_.end(),
            [](const ImagePair& x, const ImagePair& y) { return x.frames < y.frames; });
}

void PairMatcher::match_guided(const std::vector<IndexPair>& pairs, const std::vector<GuidedView>& views) {
  std::vector<ImagePair> results(pairs.size());
  base::parallel_for(pairs.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      ctx_.check_stop();
      const auto &a = views[pairs[i].first], &b = views[pairs[i].second];
      results[i].frames = pairs[i];
      if (a.far_m > 0.0 && b.far_m > 0.0) results[i] = verified(pairs[i], pair_features_guided(a, b));
    }
  });
  for (auto& result : results) {
    const auto known = std::lower_bound(matched_.begin(), matched_.end(), result.frames,
                                        [](const ImagePair& x, const IndexPair& frames) { return x.frames < frames; });
    if (known == matched_.end() || known->frames != result.frames) {
      if (!result.consistent.empty()) matched_.insert(known, std::move(result));
    } else if (result.consistent.size() > known->consistent.size()) {
      *known = std::move(result);
    }
  }
}

PairEvidence PairMatcher::evidence() const {
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

ImagePair PairMatcher::verified(const IndexPair& frames, const std::vector<FeaturePair>& paired) const {
  const ImageView &a = views_[frames.first], &b = views_[frames.second];
  ImagePair result;
  result.frames = frames;
  result.report.a = rough_.frames[frames.first].id;
  result.report.b = rough_.frames[frames.second].id;
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
  const auto views = verify_two_views(rays, two_view);
  result.report.model = views.model;
  result.report.consistent = views.inliers;
  if (views.model == TwoViewModel::none) result.report.reason = "inconsistent";
  for (std::size_t i = 0; i < paired.size(); ++i)
    if (views.inlier[i] != 0) result.consistent.push_back(paired[i]);
  return result;
}

}  // namespace cairn::adjustment
