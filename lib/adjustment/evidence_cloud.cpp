#include "adjustment/evidence_cloud.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>

#include "adjustment/patch_correlation.hpp"
#include "adjustment/robust.hpp"
#include "base/parallel.hpp"
#include "camera/projection.hpp"

namespace cairn::adjustment {
namespace {

using geometry::GreyImage;
using geometry::Vec2;
using geometry::Vec3;

constexpr float kEmpty = std::numeric_limits<float>::quiet_NaN();

struct Place {
  std::size_t row = 0, column = 0;  // first cell of the patch
  Vec2 centre = Vec2::Zero();
  double up_m = 0.0;  // median height of the patch
};

// Means of factor x factor pixels.
GreyImage shrunk(const GreyImage& image, std::size_t factor) {
  if (factor <= 1) return image;
  GreyImage small;
  small.width_px = image.width_px / factor;
  small.height_px = image.height_px / factor;
  small.values.resize(small.width_px * small.height_px);
  for (std::size_t r = 0; r < small.height_px; ++r)
    for (std::size_t c = 0; c < small.width_px; ++c) {
      std::size_t sum = 0;
      for (std::size_t y = 0; y < factor; ++y)
        for (std::size_t x = 0; x < factor; ++x) sum += image.at(r * factor + y, c * factor + x);
      small.values[r * small.width_px + c] = static_cast<std::uint8_t>(sum / (factor * factor));
    }
  return small;
}

struct View {
  const survey::Frame* frame = nullptr;
  const survey::Camera* camera = nullptr;
  GreyImage image;                // shrunk to about the surface's cell
  double image_per_camera = 1.0;  // pixels of `image` per pixel of the camera

  [[nodiscard]] float brightness(const Vec3& p_world) const {
    const auto pixel = camera::project_world(*camera, frame->T_world_camera, p_world);
    if (!pixel) return kEmpty;
    const auto value = image.sample(*pixel * image_per_camera);
    return value ? static_cast<float>(*value) : kEmpty;
  }
  // Horizontal run per metre of drop of the line of sight.
  [[nodiscard]] Vec2 slope(const Vec3& p_world) const {
    const Vec3 d = p_world - frame->T_world_camera.translation;
    return d.z() < 0.0 ? Vec2(d.head<2>() / -d.z()) : Vec2(Vec2::Constant(std::numeric_limits<double>::infinity()));
  }
};

class Comparison {
 public:
  Comparison(const survey::Survey& survey, std::span<const FrameImage> images, const CloudSurface& surface,
             const CloudEvidenceOptions& options)
      : surface_(surface), options_(options) {
    const auto& g = surface.up_m.geometry;
    patch_ = std::max<std::size_t>(8, static_cast<std::size_t>(options.patch_m / g.cell));
    margin_ = static_cast<std::size_t>(std::ceil(options.search_m / g.cell)) + 1;
    std::vector<double> heights;
    for (const float v : surface.up_m.values)
      if (!std::isnan(v)) heights.push_back(static_cast<double>(v));
    ground_ = median(std::move(heights));
    for (const auto& image : images) add_view(survey, image);
    choose_places();
  }

  [[nodiscard]] std::size_t places() const { return places_.size(); }

  // All accepted matches, by place, with the surface lowered by `vertical` [m].
  [[nodiscard]] std::vector<std::vector<CloudMatch>> run(double vertical) const {
    std::vector<std::vector<CloudMatch>> result(places_.size());
    base::parallel_for(places_.size(), 1, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) result[i] = compare(places_[i], vertical);
    });
    return result;
  }

 private:
  void add_view(const survey::Survey& survey, const FrameImage& source) {
    View view;
    view.frame = survey.frame(source.frame);
    if (view.frame == nullptr || source.image == nullptr || source.image->values.empty()) return;
    view.camera = survey.camera(view.frame->camera);
    if (view.camera == nullptr || view.camera->width_px <= 0 || !view.frame->T_world_camera.translation.allFinite())
      return;
    const double drop = view.frame->T_world_camera.translation.z() - ground_;
    const double scale = static_cast<double>(source.image->width_px) / static_cast<double>(view.camera->width_px);
    const double ground_px = drop / (view.camera->fx_px * scale);  // m a pixel
    if (!(ground_px > 0.0)) return;
    const auto factor = static_cast<std::size_t>(std::clamp(surface_.up_m.geometry.cell / ground_px, 1.0, 64.0));
    view.image = shrunk(*source.image, factor);
    view.image_per_camera = scale / static_cast<double>(factor);
    views_.push_back(std::move(view));
  }

  // Patches on a lattice of whole patches, the most contrasted first, at most options_.places.
  void choose_places() {
    const auto& g = surface_.up_m.geometry;
    std::vector<std::pair<double, Place>> ranked;
    for (std::size_t row = margin_; row + patch_ + margin_ < g.rows; row += patch_)
      for (std::size_t column = margin_; column + patch_ + margin_ < g.columns; column += patch_) {
        double n = 0, sum = 0, squares = 0;
        std::vector<double> heights;
        for (std::size_t r = row; r < row + patch_; ++r)
          for (std::size_t c = column; c < column + patch_; ++c) {
            const auto v = static_cast<double>(surface_.brightness.at(r, c));
            if (std::isnan(v)) continue;
            n += 1.0;
            sum += v;
            squares += v * v;
            heights.push_back(static_cast<double>(surface_.up_m.at(r, c)));
          }
        constexpr double kLeastFilled = 0.8;
        if (n < kLeastFilled * static_cast<double>(patch_ * patch_)) continue;
        Place place{row, column, {}, median(std::move(heights))};
        const double half = 0.5 * static_cast<double>(patch_) * g.cell;
        place.centre = {g.west + static_cast<double>(column) * g.cell + half,
                        g.north - static_cast<double>(row) * g.cell - half};
        ranked.emplace_back(squares / n - sum * sum / (n * n), place);
      }
    std::stable_sort(ranked.begin(), ranked.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
    const std::size_t count = std::min(ranked.size(), static_cast<std::size_t>(options_.places));
    for (std::size_t i = 0; i < count; ++i) places_.push_back(ranked[i].second);
  }

  [[nodiscard]] std::vector<CloudMatch> compare(const Place& place, double vertical) const {
    const Vec3 centre(place.centre.x(), place.centre.y(), place.up_m - vertical);
    std::vector<std::pair<double, const View*>> order;
    for (const auto& view : views_) {
      const double slope = view.slope(centre).norm();
      if (slope <= options_.max_view_slope && sees(view, centre)) order.emplace_back(slope, &view);
    }
    std::stable_sort(order.begin(), order.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    if (order.size() > static_cast<std::size_t>(options_.views)) order.resize(static_cast<std::size_t>(options_.views));
    Window patch{patch_, std::vector<float>(patch_ * patch_)};
    for (std::size_t r = 0; r < patch_; ++r)
      for (std::size_t c = 0; c < patch_; ++c)
        patch.values[r * patch_ + c] = surface_.brightness.at(place.row + r, place.column + c);
    std::vector<CloudMatch> matches;
    for (const auto& [slope, view] : order) {
      const auto peak = correlate(patch, ortho(*view, place, vertical));
      if (!peak || peak->correlation < options_.min_correlation) continue;
      const double cell = surface_.up_m.geometry.cell;
      matches.push_back({view->frame->id,
                         place.centre,
                         {peak->shift_cells.x() * cell, -peak->shift_cells.y() * cell},
                         view->slope(centre),
                         peak->correlation});
    }
    return matches;
  }

  // Whether the four corners of the search window fall inside the image.
  [[nodiscard]] bool sees(const View& view, const Vec3& centre) const {
    const double half = 0.5 * static_cast<double>(patch_ + 2 * margin_) * surface_.up_m.geometry.cell;
    for (const auto& [x, y] : std::array<std::pair<double, double>, 4>{{{-1, -1}, {1, -1}, {-1, 1}, {1, 1}}})
      if (std::isnan(view.brightness(centre + Vec3(x * half, y * half, 0.0)))) return false;
    return true;
  }

  // The image laid on the surface, over the patch and the search margin.
  [[nodiscard]] Window ortho(const View& view, const Place& place, double vertical) const {
    Window window{patch_ + 2 * margin_, {}};
    window.values.resize(window.side * window.side);
    for (std::size_t r = 0; r < window.side; ++r)
      for (std::size_t c = 0; c < window.side; ++c) {
        const std::size_t row = place.row - margin_ + r, column = place.column - margin_ + c;
        const Vec2 p = surface_.up_m.geometry.centre(row, column);
        const float up = surface_.up_m.at(row, column);
        const double height = std::isnan(up) ? place.up_m : static_cast<double>(up);
        window.values[r * window.side + c] = view.brightness({p.x(), p.y(), height - vertical});
      }
    return window;
  }

  const CloudSurface& surface_;
  const CloudEvidenceOptions& options_;
  std::size_t patch_ = 0, margin_ = 0;
  double ground_ = 0.0;
  std::vector<View> views_;
  std::vector<Place> places_;
};

// o_xy and o_z of s = o_xy + o_z t by reweighted least squares (Huber).
Vec3 solve_offset(const std::vector<CloudMatch>& matches) {
  constexpr int kRounds = 20;
  constexpr double kHuber = 0.1;   // m
  constexpr double kRidge = 1e-3;  // keeps o_z at 0 where all views are vertical
  Vec3 offset = Vec3::Zero();
  for (int round = 0; round < kRounds; ++round) {
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    Vec3 right = Vec3::Zero();
    normal(2, 2) = kRidge;
    for (const auto& m : matches) {
      const Vec2 residual = m.shift_m - offset.head<2>() - offset.z() * m.slope;
      const double w = round == 0 ? 1.0 : std::min(1.0, kHuber / std::max(1e-9, residual.norm()));
      for (int axis = 0; axis < 2; ++axis) {
        Vec3 row(axis == 0 ? 1.0 : 0.0, axis == 1 ? 1.0 : 0.0, m.slope[axis]);
        normal += w * row * row.transpose();
        right += w * m.shift_m[axis] * row;
      }
    }
    offset = normal.ldlt().solve(right);
    if (!offset.allFinite()) return Vec3::Zero();
  }
  return offset;
}

std::vector<CloudMatch> flat(const std::vector<std::vector<CloudMatch>>& by_place) {
  std::vector<CloudMatch> all;
  for (const auto& place : by_place) all.insert(all.end(), place.begin(), place.end());
  return all;
}

void tie_heights(const survey::Survey& survey, const CloudSurface& surface, const Vec2& horizontal,
                 CloudEvidence& evidence) {
  constexpr std::size_t kLeast = 20;
  std::vector<double> differences;
  std::vector<std::pair<double, double>> heights;  // tie, surface
  for (const auto& tie : survey.ties) {
    if (!tie.p_world.allFinite()) continue;
    const auto height = surface.height_at(tie.p_world.head<2>() + horizontal);
    if (!height) continue;
    differences.push_back(*height - tie.p_world.z());
    heights.emplace_back(tie.p_world.z(), *height);
  }
  evidence.tie_points = differences.size();
  if (differences.size() < kLeast) return;
  evidence.vertical_m = median(differences);
  evidence.vertical_scatter_m = robust_sigma(differences);
  evidence.vertical_by = "tie_points";
  // Slope between the medians of the lower and the upper third.
  std::sort(heights.begin(), heights.end());
  const std::size_t third = heights.size() / 3;
  std::array<std::vector<double>, 4> parts;
  for (std::size_t i = 0; i < third; ++i) {
    parts[0].push_back(heights[i].first);
    parts[1].push_back(heights[i].second);
    parts[2].push_back(heights[heights.size() - 1 - i].first);
    parts[3].push_back(heights[heights.size() - 1 - i].second);
  }
  const double rise = median(parts[2]) - median(parts[0]);
  constexpr double kLeastRise = 0.5;  // m: flatter ground says nothing about the scale of heights
  if (rise > kLeastRise) evidence.height_slope = (median(parts[3]) - median(parts[1])) / rise;
}

void horizontal_figures(const std::vector<std::vector<CloudMatch>>& by_place, double vertical_left,
                        const CloudEvidenceOptions& options, CloudEvidence& evidence) {
  std::vector<double> east, north;
  double correlation = 0.0;
  for (const auto& place : by_place) {
    if (place.empty()) continue;
    std::vector<double> x, y;
    for (const auto& m : place) {
      x.push_back(m.shift_m.x() - vertical_left * m.slope.x());
      y.push_back(m.shift_m.y() - vertical_left * m.slope.y());
      correlation += m.correlation;
    }
    east.push_back(median(x));
    north.push_back(median(y));
  }
  evidence.places = east.size();
  if (east.empty()) return;
  evidence.mean_correlation = correlation / static_cast<double>(evidence.matches.size());
  if (evidence.places < static_cast<std::size_t>(options.min_places)) return;
  evidence.horizontal_m = Vec2(median(east), median(north));
  evidence.horizontal_scatter_m = {robust_sigma(east), robust_sigma(north)};
}

}  // namespace

CloudEvidence cloud_evidence(const survey::Survey& survey, std::span<const FrameImage> images,
                             const CloudSurface& surface, const CloudEvidenceOptions& options) {
  auto checked = options;
  base::validate(base::bind_options(checked), "cloud evidence");
  CloudEvidence evidence;
  tie_heights(survey, surface, Vec2::Zero(), evidence);
  const bool from_ties = evidence.vertical_m.has_value();
  if (!surface.coloured || images.empty()) return evidence;
  const Comparison comparison(survey, images, surface, options);
  evidence.places_tried = comparison.places();
  double vertical = evidence.vertical_m.value_or(0.0);
  auto by_place = comparison.run(vertical);
  if (!from_ties) {
    // The first pass saw the surface at a wrong height: a second one sees it where it is.
    vertical = solve_offset(flat(by_place)).z();
    by_place = comparison.run(vertical);
  }
  evidence.matches = flat(by_place);
  const double left = from_ties ? 0.0 : solve_offset(evidence.matches).z();
  horizontal_figures(by_place, left, options, evidence);
  if (from_ties) {
    if (evidence.horizontal_m) tie_heights(survey, surface, *evidence.horizontal_m, evidence);
  } else if (evidence.horizontal_m) {
    evidence.vertical_m = vertical + left;
    evidence.vertical_by = "parallax";
    // Each match constrains o_z by its residual along the view's slope.
    std::vector<double> residuals;
    for (const auto& m : evidence.matches) {
      constexpr double kLeastSlope = 0.1;
      const double slope = m.slope.norm();
      if (slope > kLeastSlope)
        residuals.push_back((m.shift_m - *evidence.horizontal_m - left * m.slope).dot(m.slope) / (slope * slope));
    }
    evidence.vertical_scatter_m = robust_sigma(residuals);
  }
  return evidence;
}

}  // namespace cairn::adjustment
