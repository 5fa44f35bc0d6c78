#include "simulation/detector.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "base/angle.hpp"
#include "base/error.hpp"
#include "base/parallel.hpp"
#include "camera/projection.hpp"

namespace cairn::simulation {
namespace {

using geometry::PixelBox;
using geometry::Vec2;
using geometry::Vec3;

std::string sought_class(const Scene& scene) {
  for (const auto& object : scene.objects)
    if (object.sought) return object.object_class;
  return scene.objects.empty() ? "object" : scene.objects[0].object_class;
}

double kept_score(double score) {
  // Two decimals, as detectors print them.
  return std::round(100.0 * std::clamp(score, 0.05, 1.0)) / 100.0;
}

// Box with jittered edges, inside the image; empty where nothing is left of it.
std::optional<PixelBox> jittered(const PixelBox& box, const Detector& detector, const survey::Camera& camera,
                                 base::Random& random) {
  const double sx = std::hypot(detector.jitter_px, detector.jitter_share * box.width());
  const double sy = std::hypot(detector.jitter_px, detector.jitter_share * box.height());
  PixelBox b{box.xmin + sx * random.normal(), box.ymin + sy * random.normal(), box.xmax + sx * random.normal(),
             box.ymax + sy * random.normal()};
  const auto w = static_cast<double>(camera.width_px), h = static_cast<double>(camera.height_px);
  b = {std::clamp(b.xmin, 0.0, w), std::clamp(b.ymin, 0.0, h), std::clamp(b.xmax, 0.0, w), std::clamp(b.ymax, 0.0, h)};
  constexpr double kLeast = 1.0;  // px
  if (b.width() < kLeast || b.height() < kLeast) return std::nullopt;
  return b;
}

// Outline of a sphere, by its rim seen from the camera; empty where it is not wholly in the image.
std::optional<PixelBox> sphere_box(const Vec3& centre, double radius, const survey::Camera& camera,
                                   const geometry::RigidTransform& T) {
  const Vec3 way = centre - T.translation;
  const double distance = way.norm();
  if (distance < 1.5 * radius) return std::nullopt;
  const Vec3 forward = way / distance;
  const Vec3 right = forward.cross(std::abs(forward.z()) < 0.9 ? Vec3::UnitZ() : Vec3::UnitX()).normalized();
  const Vec3 up = right.cross(forward);
  const double back = radius * radius / distance,
               rim = radius * std::sqrt(1.0 - radius * radius / (distance * distance));
  PixelBox box;
  constexpr int kRim = 24;
  for (int i = 0; i < kRim; ++i) {
    const double a = 2.0 * std::numbers::pi * i / kRim;
    const auto pixel =
        camera::project_world(camera, T, centre - back * forward + rim * (std::cos(a) * right + std::sin(a) * up));
    if (!pixel || !camera::inside_image(camera, *pixel)) return std::nullopt;
    if (i == 0) box = {pixel->x(), pixel->y(), pixel->x(), pixel->y()};
    box = {std::min(box.xmin, pixel->x()), std::min(box.ymin, pixel->y()), std::max(box.xmax, pixel->x()),
           std::max(box.ymax, pixel->y())};
  }
  return box;
}

std::int64_t poisson(double mean, base::Random& random) {
  // Knuth's product method; means of a detector are small.
  double product = random.uniform();
  std::int64_t count = 0;
  for (const double limit = std::exp(-mean); product > limit; product *= random.uniform()) ++count;
  return count;
}

// For each object its frames in order -> whether it is missed, as a two-state Markov chain: stationary share of misses
// miss_rate, mean run of misses miss_run_frames.
class Misses {
 public:
  Misses(const Detector& detector, std::uint64_t seed, std::size_t objects) : rate_(detector.miss_rate) {
    recover_ = 1.0 / detector.miss_run_frames;
    lapse_ = rate_ < 1.0 ? std::min(1.0, recover_ * rate_ / (1.0 - rate_)) : 1.0;
    for (std::size_t i = 0; i < objects; ++i) {
      random_.emplace_back(seed, "simulation misses", i);
      missed_.push_back(random_.back().uniform() < rate_);
    }
  }
  bool next(std::size_t object) {
    const bool now = missed_[object];
    const double u = random_[object].uniform();
    missed_[object] = rate_ >= 1.0 || (now ? u >= recover_ : u < lapse_);
    return now;
  }

 private:
  double rate_, recover_ = 1.0, lapse_ = 0.0;
  std::vector<base::Random> random_;
  std::vector<bool> missed_;
};

struct Found {
  survey::Detection detection;
  survey::DetectionOrigin origin;
};

class FrameDetector {
 public:
  FrameDetector(const Scene& scene, std::string false_class) : scene_(scene), false_class_(std::move(false_class)) {}

  [[nodiscard]] Found found(const PixelBox& box, std::string object_class, double score) const {
    Found f;
    f.detection.object_class = std::move(object_class);
    f.detection.score = kept_score(score);
    f.detection.box = box;
    return f;
  }

  void objects(const survey::Camera& camera, const std::vector<SeenBox>& boxes, const std::vector<std::uint8_t>& missed,
               const std::vector<PlacedObject>& placed, base::Random& random, std::vector<Found>& out) const {
    const Detector& d = scene_.detector;
    for (std::size_t i = 0; i < boxes.size(); ++i) {
      // Every box draws the same numbers, whatever becomes of it.
      const auto box = jittered(boxes[i].truth.box, d, camera, random);
      const double score = d.score_mean + d.score_sigma * random.normal();
      const double confusion = random.uniform();
      if (missed[i] != 0 || !box) continue;
      const auto& object = placed[static_cast<std::size_t>(boxes[i].truth.object.value - 1)].truth;
      std::string name = object.object_class;
      for (const Confusion& c : scene_.confusions)
        if (c.of == object.object_class && confusion < c.probability) name = c.as;
      out.push_back(found(*box, std::move(name), score));
      out.back().origin.object = object.id;
    }
  }

  void clutter(const survey::Camera& camera, const Exposure& exposure, const std::vector<ClutterPlace>& places,
               const Obstruction& obstruction, base::Random& random, std::vector<Found>& out) const {
    for (std::size_t i = 0; i < places.size(); ++i) {
      const ClutterPlace& place = places[i];
      const auto outline = sphere_box(place.centre, place.radius_m, camera, exposure.T_world_camera);
      if (!outline) continue;
      const double luck = random.uniform();
      const auto box = jittered(*outline, scene_.detector, camera, random);
      const double score = scene_.detector.false_score_mean + scene_.detector.false_score_sigma * random.normal();
      if (luck >= place.hit_probability || !box) continue;
      const Vec2 way = (exposure.T_world_camera.translation - place.centre).head<2>();
      const double off = std::remainder(base::azimuth_deg(way.x(), way.y()) - place.azimuth_deg, 360.0);
      if (std::abs(off) > 0.5 * place.sector_deg) continue;
      if (std::min(box->width(), box->height()) < scene_.detector.min_size_px) continue;
      if (!obstruction.free(exposure.T_world_camera.translation, place.centre + Vec3(0, 0, 0.9 * place.radius_m)))
        continue;
      out.push_back(found(*box, place.object_class, score));
      out.back().origin.clutter = static_cast<std::int64_t>(i);
    }
  }

  void sporadic(const survey::Camera& camera, base::Random& random, std::vector<Found>& out) const {
    const Detector& d = scene_.detector;
    const std::int64_t count = poisson(d.false_per_image, random);
    const auto w = static_cast<double>(camera.width_px), h = static_cast<double>(camera.height_px);
    for (std::int64_t i = 0; i < count; ++i) {
      const double width = std::min(w, random.uniform(d.false_size_lo_px, d.false_size_hi_px));
      const double height = std::min(h, random.uniform(d.false_size_lo_px, d.false_size_hi_px));
      const double x = random.uniform(0.0, w - width), y = random.uniform(0.0, h - height);
      const double score = d.false_score_mean + d.false_score_sigma * random.normal();
      out.push_back(found({x, y, x + width, y + height}, false_class_, score));
    }
  }

 private:
  const Scene& scene_;
  std::string false_class_;
};

}  // namespace

std::vector<ClutterPlace> place_clutter(const Scene& scene, std::uint64_t seed, const Ground& ground) {
  std::vector<ClutterPlace> result;
  for (std::size_t k = 0; k < scene.detector.clutter.size(); ++k) {
    const Clutter& spec = scene.detector.clutter[k];
    base::Random random(seed, "simulation clutter", k);
    for (std::int64_t copy = 0; copy < spec.count; ++copy) {
      const Vec2 place = spec.position ? *spec.position : random_point_in(spec.area, random);
      const auto up = ground.height(place);
      if (!up)
        throw base::Error(base::ErrorCode::failed_precondition, "clutter does not stand on the ground")
            .record("detector.clutter[" + std::to_string(k) + "]")
            .hint("Keep its place or area inside the terrain");
      ClutterPlace c;
      c.radius_m = 0.5 * spec.size_m;
      c.centre = {place.x(), place.y(), *up + c.radius_m};
      c.hit_probability = spec.hit_probability;
      c.sector_deg = spec.sector_deg;
      c.azimuth_deg = spec.azimuth_deg ? *spec.azimuth_deg : random.uniform(0.0, 360.0);
      c.object_class = spec.object_class.empty() ? sought_class(scene) : spec.object_class;
      result.push_back(c);
    }
  }
  return result;
}

Detections detect(const Scene& scene, std::uint64_t seed, const std::vector<Exposure>& exposures,
                  const std::vector<std::vector<SeenBox>>& boxes, const std::vector<PlacedObject>& objects,
                  const std::vector<ClutterPlace>& clutter, const Obstruction& obstruction) {
  const Detector& d = scene.detector;
  Misses misses(d, seed, objects.size());
  std::vector<std::vector<std::uint8_t>> missed(boxes.size());
  for (std::size_t i = 0; i < boxes.size(); ++i)
    for (const SeenBox& box : boxes[i]) {
      const bool lapse = misses.next(static_cast<std::size_t>(box.truth.object.value - 1));
      const auto& object = objects[static_cast<std::size_t>(box.truth.object.value - 1)].truth;
      const bool hard = std::find(d.blind_to.begin(), d.blind_to.end(), object.object_class) != d.blind_to.end() ||
                        box.truth.visible_share < d.min_visible_share || box.inside_share < d.min_inside_share ||
                        std::min(box.truth.box.width(), box.truth.box.height()) < d.min_size_px;
      missed[i].push_back(lapse || hard ? 1 : 0);
    }

  std::vector<std::vector<Found>> found(exposures.size());
  const FrameDetector frame_detector(scene, sought_class(scene));
  base::parallel_for(exposures.size(), 64, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const auto& camera = scene.cameras[exposures[i].camera];
      base::Random random(seed, "simulation detections", i), false_random(seed, "simulation clutter hits", i),
          sporadic_random(seed, "simulation false boxes", i);
      frame_detector.objects(camera, boxes[i], missed[i], objects, random, found[i]);
      frame_detector.clutter(camera, exposures[i], clutter, obstruction, false_random, found[i]);
      frame_detector.sporadic(camera, sporadic_random, found[i]);
    }
  });

  Detections result;
  for (std::size_t i = 0; i < found.size(); ++i)
    for (Found& f : found[i]) {
      f.detection.id = survey::DetectionId(static_cast<std::int64_t>(result.detections.size()) + 1);
      f.detection.frame = survey::FrameId(static_cast<std::int64_t>(i) + 1);
      f.origin.detection = f.detection.id;
      result.detections.push_back(std::move(f.detection));
      result.origins.push_back(f.origin);
    }
  return result;
}

}  // namespace cairn::simulation
