#include "pipeline/coverage_frames.hpp"

#include <algorithm>
#include <cmath>
#include <system_error>

#include "base/error.hpp"
#include "io/csv.hpp"
#include "io/image_metadata.hpp"
#include "io/survey_folder.hpp"

namespace cairn::pipeline {
namespace fs = std::filesystem;
namespace {

using survey::Frame;

// Distance over time between the frames before and after, at one end between a frame and its neighbour.
std::optional<double> speed(const std::vector<const Frame*>& by_time, std::size_t i) {
  constexpr double kNanoseconds = 1e-9;
  const auto from_to = [&](std::size_t a, std::size_t b) -> std::optional<double> {
    const double seconds = kNanoseconds * static_cast<double>(by_time[b]->time_ns - by_time[a]->time_ns);
    if (!(seconds > 0.0) || seconds > kLongestPause) return std::nullopt;
    return (by_time[b]->T_world_camera.translation - by_time[a]->T_world_camera.translation).norm() / seconds;
  };
  std::optional<double> before, after;
  if (i > 0) before = from_to(i - 1, i);
  if (i + 1 < by_time.size()) after = from_to(i, i + 1);
  if (before && after) return 0.5 * (*before + *after);
  return before ? before : after;
}

std::optional<double> exposure(const fs::path& image, base::RunContext& ctx) {
  std::error_code ignored;
  if (image.empty() || !fs::is_regular_file(image, ignored)) return std::nullopt;
  try {
    return io::read_image_metadata(image).exposure_s;
  } catch (const base::Error& e) {
    ctx.warn(image.filename().string() + ": " + e.what());
    return std::nullopt;
  }
}

}  // namespace

std::vector<FrameFigures> frame_figures(const CoverageViews& views, const fs::path& folder,
                                        const visibility::Scene& scene, base::RunContext& ctx) {
  std::vector<geometry::Ray> axes;
  for (const coverage::View& view : views.set.views)
    axes.push_back({view.T_world_camera.translation, view.T_world_camera.rotation.col(2)});
  const auto hits = scene.cast(axes);
  // Where the axis meets a hole: the plane at the median height of where the others meet the surface.
  std::vector<double> heights;
  for (std::size_t i = 0; i < axes.size(); ++i)
    if (hits[i].hit()) heights.push_back(axes[i].origin.z() + hits[i].distance * axes[i].direction.z());
  std::sort(heights.begin(), heights.end());
  const auto range_of = [&](std::size_t i) -> std::optional<double> {
    if (hits[i].hit()) return hits[i].distance;
    if (heights.empty()) return std::nullopt;
    const double range = (heights[(heights.size() - 1) / 2] - axes[i].origin.z()) / axes[i].direction.z();
    return range > 0.0 && std::isfinite(range) ? std::optional(range) : std::nullopt;
  };
  std::vector<FrameFigures> result;
  for (std::size_t i = 0; i < axes.size(); ++i) {
    const survey::Camera& camera = views.set.cameras[views.set.views[i].camera];
    FrameFigures f;
    f.frame = views.set.views[i].frame;
    if (const auto range = range_of(i)) {
      constexpr double kMillimetres = 1000.0;
      f.range_m = *range;
      f.gsd_mm = kMillimetres * *range / std::sqrt(camera.fx_px * camera.fy_px);
    }
    result.push_back(std::move(f));
  }
  if (!views.survey) return result;
  std::vector<const Frame*> by_time;
  for (const Frame& frame : views.survey->frames)
    if (frame.time_ns != 0) by_time.push_back(&frame);
  std::stable_sort(by_time.begin(), by_time.end(),
                   [](const Frame* a, const Frame* b) { return a->time_ns < b->time_ns; });
  for (std::size_t i = 0; i < result.size(); ++i) {
    ctx.check_stop();
    const Frame& frame = views.survey->frames[i];
    FrameFigures& f = result[i];
    f.image = frame.image;
    if (const auto at = std::find(by_time.begin(), by_time.end(), &frame); at != by_time.end())
      f.speed_m_s = speed(by_time, static_cast<std::size_t>(at - by_time.begin()));
    if (!frame.image.empty()) f.exposure_s = exposure(io::resolve_reference(frame.image, folder), ctx);
    if (f.speed_m_s && f.exposure_s && f.gsd_mm) {
      constexpr double kMillimetres = 1000.0;
      f.blur_px = kMillimetres * *f.speed_m_s * *f.exposure_s / *f.gsd_mm;
    }
  }
  return result;
}

void write_frame_rows(const fs::path& path, const std::vector<FrameFigures>& frames) {
  io::CsvWriter csv(path, {"frame_id", "image", "range_m", "gsd_mm", "speed_m_s", "exposure_s", "blur_px"});
  for (const FrameFigures& f : frames) {
    csv.cell(f.frame.value).cell(f.image).cell(f.range_m).cell(f.gsd_mm).cell(f.speed_m_s).cell(f.exposure_s);
    csv.cell(f.blur_px).end_row();
  }
  csv.finish();
}

}  // namespace cairn::pipeline
