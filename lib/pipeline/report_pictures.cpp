#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <string>

#include "base/error.hpp"
#include "base/number_text.hpp"
#include "io/image.hpp"
#include "io/image_crop.hpp"
#include "io/survey_folder.hpp"
#include "pipeline/report_parts.hpp"
#include "pipeline/survey_sources.hpp"

namespace cairn::pipeline {
namespace {

struct Wanted {
  std::size_t target, place;  // index of the target, place among its photographs
  const survey::Detection* detection;
};

// The best detections of a target, one a photograph.
std::vector<const survey::Detection*> best_detections(const survey::Target& target, const survey::Survey& survey,
                                                      std::size_t count) {
  std::vector<const survey::Detection*> all;
  for (const survey::DetectionId id : target.detections)
    if (const survey::Detection* d = survey.detection(id)) all.push_back(d);
  std::stable_sort(all.begin(), all.end(), [](const auto* a, const auto* b) { return a->score > b->score; });
  std::vector<const survey::Detection*> out;
  std::set<survey::FrameId> used;
  for (const survey::Detection* d : all)
    if (out.size() < count && used.insert(d->frame).second) out.push_back(d);
  return out;
}

// A cell without a point among neighbours that have some takes their mean: the cloud's own grain, not a gap.
void fill_pinholes(report::ColourView& view) {
  constexpr std::size_t kNeighbours = 4;  // of eight
  const std::vector<std::uint8_t> known = view.mask;
  const std::size_t columns = view.geometry.columns, rows = view.geometry.rows;
  for (std::size_t r = 1; r + 1 < rows; ++r)
    for (std::size_t c = 1; c + 1 < columns; ++c) {
      if (known[r * columns + c] != 0) continue;
      std::array<std::size_t, 3> sum{};
      std::size_t n = 0;
      for (std::size_t y = r - 1; y <= r + 1; ++y)
        for (std::size_t x = c - 1; x <= c + 1; ++x) {
          if (known[y * columns + x] == 0) continue;
          for (std::size_t k = 0; k < 3; ++k) sum[k] += view.colours[y * columns + x][k];
          ++n;
        }
      if (n < kNeighbours) continue;
      view.mask[r * columns + c] = 1;
      for (std::size_t k = 0; k < 3; ++k) view.colours[r * columns + c][k] = static_cast<std::uint8_t>(sum[k] / n);
    }
}

}  // namespace

void add_photos(std::vector<report::TargetView>& targets, const survey::Survey& survey,
                const std::filesystem::path& survey_folder, const ReportStageOptions& options, base::RunContext& ctx) {
  std::map<survey::FrameId, std::vector<Wanted>> by_frame;
  std::vector<std::vector<report::Photo>> photos(targets.size());
  for (std::size_t t = 0; t < targets.size(); ++t) {
    const auto best = best_detections(targets[t].target, survey, static_cast<std::size_t>(options.photos_per_object));
    photos[t].resize(best.size());
    for (std::size_t i = 0; i < best.size(); ++i) by_frame[best[i]->frame].push_back({t, i, best[i]});
  }
  io::ImageCropOptions crop;
  crop.max_side_px = options.photo_px;
  std::uint64_t done = 0;
  for (const auto& [id, wanted] : by_frame) {
    ctx.check_stop();
    ctx.progress("photographs", ++done, by_frame.size());
    const survey::Frame* frame = survey.frame(id);
    if (frame == nullptr || frame->image.empty()) continue;
    const survey::Camera* camera = survey.camera(frame->camera);
    try {
      const auto file = io::resolve_reference(frame->image, survey_folder);
      const io::ImageHeader header = io::read_image_header(file);
      // Boxes are in the camera's pixels; the file may have been resized since.
      const double scale = camera == nullptr || camera->width_px <= 0
                               ? 1.0
                               : static_cast<double>(header.width_px) / static_cast<double>(camera->width_px);
      std::vector<geometry::PixelBox> boxes;
      for (const Wanted& w : wanted) {
        const geometry::PixelBox& b = w.detection->box;
        boxes.push_back({b.xmin * scale, b.ymin * scale, b.xmax * scale, b.ymax * scale});
      }
      std::vector<std::string> crops = io::crop_jpegs(file, boxes, crop);
      for (std::size_t i = 0; i < wanted.size(); ++i)
        photos[wanted[i].target][wanted[i].place] = {
            file.filename().string() + ", score " + base::to_fixed(wanted[i].detection->score, 2), "image/jpeg",
            std::move(crops[i])};
    } catch (const base::Error& error) {
      ctx.warn(std::string("the report has no crops of a photograph: ") + error.what());
    }
  }
  for (std::size_t t = 0; t < targets.size(); ++t)
    for (report::Photo& photo : photos[t])
      if (!photo.bytes.empty()) targets[t].photos.push_back(std::move(photo));
}

std::optional<report::ColourView> cloud_colours(const survey::Survey& survey,
                                                const std::filesystem::path& survey_folder, double cell,
                                                base::RunContext& ctx) {
  if (!has_cloud(survey)) return std::nullopt;
  const SurveyCloud source = load_cloud(survey_folder, survey, ctx);
  const geometry::PointCloud& cloud = source.cloud;
  if (cloud.colours.size() != cloud.size() || cloud.empty()) return std::nullopt;
  geometry::Vec2 min = cloud.positions.front().head<2>(), max = min;
  for (const auto& p : cloud.positions) {
    min = min.cwiseMin(p.head<2>());
    max = max.cwiseMax(p.head<2>());
  }
  // A cloud far larger than the map can show is coloured at the map's own resolution.
  constexpr double kMaxCells = 4000.0;
  const double size = std::max(cell, (max - min).maxCoeff() / kMaxCells);
  report::ColourView view;
  view.geometry = geometry::covering_grid(min, max, size);
  std::vector<std::array<std::uint64_t, 4>> sums(view.geometry.cells());
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const auto at = view.geometry.cell_at(cloud.positions[i].head<2>());
    if (!at) continue;
    auto& sum = sums[at->first * view.geometry.columns + at->second];
    for (std::size_t k = 0; k < 3; ++k) sum[k] += cloud.colours[i][k];
    ++sum[3];
  }
  view.colours.resize(sums.size());
  view.mask.assign(sums.size(), 0);
  for (std::size_t i = 0; i < sums.size(); ++i) {
    if (sums[i][3] == 0) continue;
    view.mask[i] = 1;
    for (std::size_t k = 0; k < 3; ++k) view.colours[i][k] = static_cast<std::uint8_t>(sums[i][k] / sums[i][3] >> 8U);
  }
  fill_pinholes(view);
  return view;
}

}  // namespace cairn::pipeline
