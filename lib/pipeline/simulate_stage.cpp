#include "pipeline/simulate_stage.hpp"

#include <algorithm>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "io/cloud.hpp"
#include "io/image.hpp"
#include "io/ply.hpp"
#include "io/survey_folder.hpp"
#include "io/truth.hpp"
#include "simulation/render.hpp"
#include "simulation/simulate.hpp"

namespace cairn::pipeline {
namespace fs = std::filesystem;
namespace {

using simulation::Recording;
using simulation::Scene;

void make_exact(std::vector<survey::Frame>& frames) {
  for (auto& frame : frames) frame.T_world_camera = io::exact_pose(frame.T_world_camera);
}

void add_source(survey::Manifest& manifest, const std::string& kind, const std::string& path,
                const std::string& convention) {
  survey::Source source;
  source.kind = kind;
  source.path = path;
  source.convention = convention;
  source.crs = "local";
  source.height_type = survey::HeightType::ellipsoidal;
  manifest.sources.push_back(std::move(source));
}

void write_meshes(const fs::path& out, Recording& recording) {
  for (std::size_t i = 0; i < recording.shapes.size(); ++i) {
    auto& object = recording.truth.objects[i];
    object.mesh = io::truth_mesh_name(object.id);
    io::write_truth_mesh(out, object.id, recording.shapes[i].body);
  }
  fs::create_directories(out / "truth");
  io::write_ply(out / "truth" / "terrain.ply", recording.terrain);
}

std::string picture_name(const std::string& folder, survey::FrameId id, const std::string& extension) {
  std::string number = std::to_string(id.value);
  return folder + "/" + std::string(number.size() < 6 ? 6 - number.size() : 0, '0') + number + "." + extension;
}

class Pictures {
 public:
  Pictures(const Scene& scene, const Recording& recording, fs::path out)
      : scene_(scene),
        recording_(recording),
        out_(std::move(out)),
        world_(simulation::render_bodies(scene, recording), scene.products.lighting) {
    for (const auto& [wanted, name] :
         {std::pair(scene.products.images, "images"), std::pair(scene.products.depth, "depth"),
          std::pair(scene.products.masks, "masks")})
      if (wanted) fs::create_directories(out_ / name);
  }

  void write(const survey::Frame& frame, std::uint64_t seed) const {
    const auto& products = scene_.products;
    auto options = products.render;
    options.image = products.images;
    const auto number = static_cast<std::uint64_t>(frame.id.value);
    const auto& camera = *recording_.survey.camera(frame.camera);
    auto picture = simulation::render(world_, camera, frame.T_world_camera, options, seed, number);
    if (products.images) io::write_rgb_image(out_ / frame.image, picture.width_px, picture.height_px, picture.rgb);
    if (products.masks)
      io::write_grey16_png(out_ / picture_name("masks", frame.id, "png"), picture.width_px, picture.height_px,
                           picture.instance);
    if (!products.depth) return;
    simulation::add_depth_noise(picture, products.depth_noise, seed, number);
    io::write_grey16_png(out_ / picture_name("depth", frame.id, "png"), picture.width_px, picture.height_px,
                         simulation::depth_millimetres(picture));
  }

 private:
  const Scene& scene_;
  const Recording& recording_;
  fs::path out_;
  simulation::RenderScene world_;
};

void write_pictures(const Scene& scene, const Recording& recording, const fs::path& out, base::RunContext& ctx) {
  const auto& products = scene.products;
  if (!products.images && !products.depth && !products.masks) return;
  const Pictures pictures(scene, recording, out);
  std::uint64_t done = 0;
  for (const auto& frame : recording.truth.frames) {
    ctx.check_stop();
    ctx.progress("frames", done++, recording.truth.frames.size());
    pictures.write(frame, recording.truth.seed);
  }
  ctx.progress("frames", done, recording.truth.frames.size());
}

// Frames at even steps through the flight.
std::vector<simulation::View> chosen_views(const Scene& scene, const Recording& recording) {
  const auto& frames = recording.truth.frames;
  const auto count = std::min<std::size_t>(frames.size(), static_cast<std::size_t>(scene.products.cloud_views));
  std::vector<simulation::View> views;
  for (std::size_t i = 0; i < count; ++i) {
    const auto& frame = frames[i * frames.size() / count];
    views.push_back({*recording.survey.camera(frame.camera), frame.T_world_camera});
  }
  return views;
}

std::size_t write_scene_cloud(const Scene& scene, const Recording& recording, const fs::path& out,
                              base::RunContext& ctx) {
  const simulation::RenderScene world(simulation::render_bodies(scene, recording), scene.products.lighting);
  const auto cloud = simulation::sample_cloud(world, chosen_views(scene, recording), *scene.products.cloud, ctx);
  io::write_cloud(out / "cloud.las", cloud);
  return cloud.size();
}

io::Json counts(const Recording& recording) {
  const auto sought = std::count_if(recording.truth.objects.begin(), recording.truth.objects.end(),
                                    [](const auto& object) { return object.sought; });
  const auto whole = std::count_if(recording.truth.boxes.begin(), recording.truth.boxes.end(),
                                   [](const auto& box) { return box.whole; });
  const auto& frames = recording.survey.frames;
  return io::Json::object({{"scene", recording.truth.scene},
                           {"frames", frames.size()},
                           {"duration_s", 1e-9 * static_cast<double>(frames.back().time_ns - frames.front().time_ns)},
                           {"objects", recording.truth.objects.size()},
                           {"sought", static_cast<std::int64_t>(sought)},
                           {"true_boxes", recording.truth.boxes.size()},
                           {"whole_boxes", static_cast<std::int64_t>(whole)},
                           {"terrain_triangles", recording.terrain.triangles.size()}});
}

}  // namespace

io::Json simulate_plan(const Scene& scene, base::RunContext& ctx) {
  const Recording recording = simulation::simulate(scene, ctx.seed, ctx);
  io::Json plan = counts(recording);
  const auto& products = scene.products;
  plan.set("pictures", recording.survey.frames.size() *
                           static_cast<std::size_t>(int{products.images} + int{products.depth} + int{products.masks}));
  return plan;
}

Outcome simulate_stage(const Scene& scene, const fs::path& out, base::RunContext& ctx) {
  Recording recording = simulation::simulate(scene, ctx.seed, ctx);
  make_exact(recording.survey.frames);
  make_exact(recording.truth.frames);
  auto& manifest = recording.survey.manifest;
  const auto& products = scene.products;
  if (products.images) add_source(manifest, "images", "images", "Rendered at the true poses; raw, not rectified");
  if (products.depth)
    add_source(manifest, "depth", "depth", "16-bit PNG, millimetres along the camera's z axis, 0 = no return");
  if (products.masks)
    add_source(manifest, "masks", "masks", "16-bit PNG, object id + 1 where the pixel shows the object, else 0");
  if (products.cloud)
    add_source(manifest, "cloud", "cloud.las", "Sampled from the true surface; columns label and target_id are true");
  if (products.meshes) write_meshes(out, recording);
  io::write_truth(recording.truth, manifest.origin, out);
  io::write_survey(recording.survey, out);
  write_pictures(scene, recording, out, ctx);
  io::Json summary = counts(recording);
  const auto& origins = recording.truth.detections;
  const auto count = [&](auto&& is) {
    return static_cast<std::int64_t>(std::count_if(origins.begin(), origins.end(), is));
  };
  summary.set("detections", recording.survey.detections.size());
  summary.set("of_objects", count([](const auto& o) { return o.object.valid(); }));
  summary.set("of_clutter", count([](const auto& o) { return !o.object.valid() && o.clutter >= 0; }));
  summary.set("sporadic", count([](const auto& o) { return !o.object.valid() && o.clutter < 0; }));
  if (products.cloud) summary.set("cloud_points", write_scene_cloud(scene, recording, out, ctx));
  return {std::move(summary), {}};
}

}  // namespace cairn::pipeline
