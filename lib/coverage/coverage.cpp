#include "coverage/coverage.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>

#include "base/angle.hpp"
#include "base/error.hpp"
#include "base/parallel.hpp"
#include "coverage/facet_tiles.hpp"
#include "coverage/sight_lines.hpp"
#include "coverage/view_frustum.hpp"

namespace cairn::coverage {
namespace {

using geometry::TriangleMesh;
using geometry::Vec3;

constexpr std::size_t kTilesAtOnce = 512;  // between two looks at the stop flag
constexpr float kLargest = std::numeric_limits<float>::max();
constexpr float kNone = std::numeric_limits<float>::quiet_NaN();

enum class Side { outside, inside, across };

// Where a tile's box of centroids lies for a view.
Side side_of(const ViewFrustum& view, const FacetTile& tile) {
  const Vec3 d = tile.centre - view.centre;
  for (const Vec3& n : view.outer)
    if (n.dot(d) + n.cwiseAbs().dot(tile.half) < 0.0) return Side::outside;
  if (!view.has_inner) return Side::across;
  for (const Vec3& n : view.inner)
    if (!(n.dot(d) - n.cwiseAbs().dot(tile.half) > 0.0)) return Side::across;
  return Side::inside;
}

// A view that sees a facet of the tile.
struct Sighting {
  std::uint16_t local = 0;  // facet's place in the tile
  float x = 0.0F, y = 0.0F, z = 0.0F;
  float gsd_mm = 0.0F;
  float versine = 0.0F;  // 1 - cos(incidence): keeps its digits near normal incidence
};

// The facets of one tile, by component, and room to work in.
class TileWork {
 public:
  TileWork(const TriangleMesh& mesh, const FacetTiles& tiles, const visibility::Scene& scene,
           const std::vector<ViewFrustum>& views, const CoverageOptions& options, FacetCoverage& out)
      : mesh_(mesh), tiles_(tiles), scene_(scene), views_(views), options_(options), out_(out) {}

  void run(const FacetTile& tile) {
    load(tile);
    sightings_.clear();
    for (const ViewFrustum& view : views_) {
      const Side side = side_of(view, tile);
      if (side != Side::outside) look(view, side);
    }
    for (std::size_t k = 0; k < count_; ++k) {
      const std::uint32_t facet = facet_[k];
      out_.views[facet] = seen_[k];
      out_.in_frame[facet] = in_frame_[k];
      out_.facing[facet] = facing_[k];
    }
    if (options_.metrics) measure();
  }
  [[nodiscard]] std::uint64_t rays() const { return rays_; }

 private:
  void load(const FacetTile& tile) {
    count_ = tile.end - tile.begin;
    for (std::size_t k = 0; k < count_; ++k) {
      facet_[k] = tiles_.order[tile.begin + k];
      const Vec3 c = mesh_.centroid(facet_[k]);
      const Vec3 n = mesh_.area_vector(facet_[k]).normalized();
      cx_[k] = c.x();
      cy_[k] = c.y();
      cz_[k] = c.z();
      nx_[k] = n.x();
      ny_[k] = n.y();
      nz_[k] = n.z();
      in_frame_[k] = facing_[k] = seen_[k] = 0;
    }
  }

  void look(const ViewFrustum& view, Side side) {
    classify(view, side);
    // Facets inside the frame that face the camera, one after another.
    std::size_t n = 0;
    for (std::size_t k = 0; k < count_; ++k) {
      if (inside_[k] == 0) continue;
      const Vec3 c(cx_[k], cy_[k], cz_[k]);
      if (side == Side::across && !view.bounds->exact && !view.sees(c)) continue;
      ++in_frame_[k];
      if (faces_[k] == 0) continue;
      ++facing_[k];
      local_[n] = static_cast<std::uint16_t>(k);
      target_[n++] = c;
    }
    if (n == 0) return;
    rays_ += n;
    scene_.blocked_from(view.centre, std::span(target_).first(n), std::span(blocked_).first(n), options_.end_gap);
    for (std::size_t i = 0; i < n; ++i) {
      if (blocked_[i] != 0) continue;
      ++seen_[local_[i]];
      if (options_.metrics) note(view, local_[i]);
    }
  }

  // inside_: not outside the frustum's planes; faces_: turned to the camera. Plain loops over components, so that
  // the compiler works on several facets at once.
  void classify(const ViewFrustum& view, Side side) {
    const double px = view.centre.x(), py = view.centre.y(), pz = view.centre.z();
    for (std::size_t k = 0; k < count_; ++k)
      faces_[k] = nx_[k] * (px - cx_[k]) + ny_[k] * (py - cy_[k]) + nz_[k] * (pz - cz_[k]) > 0.0 ? 1 : 0;
    if (side == Side::inside) {
      std::fill_n(inside_.begin(), count_, std::uint8_t{1});
      return;
    }
    const auto& p = view.outer;
    for (std::size_t k = 0; k < count_; ++k) {
      const double x = cx_[k] - px, y = cy_[k] - py, z = cz_[k] - pz;
      double least = p[0].x() * x + p[0].y() * y + p[0].z() * z;
      for (std::size_t i = 1; i < 4; ++i) least = std::min(least, p[i].x() * x + p[i].y() * y + p[i].z() * z);
      const double depth = p[4].x() * x + p[4].y() * y + p[4].z() * z;
      inside_[k] = (least >= 0.0) & (depth > 0.0 || !view.bounds->bounded) ? 1 : 0;
    }
  }

  void note(const ViewFrustum& view, std::uint16_t k) {
    const Vec3 d(view.centre.x() - cx_[k], view.centre.y() - cy_[k], view.centre.z() - cz_[k]);
    const double range = d.norm();
    const Vec3 line = d / range;
    const double cosine = std::clamp(line.x() * nx_[k] + line.y() * ny_[k] + line.z() * nz_[k], 0.0, 1.0);
    const Vec3 p = view.R_camera_world * (-d);
    const survey::Camera& camera = view.bounds->camera;
    const double magnification = view.bounds->exact ? 1.0 : view.bounds->magnification(p.x() / p.z(), p.y() / p.z());
    const double area = p.z() * p.z() * p.z() / (range * camera.fx_px * camera.fy_px * magnification * cosine);
    constexpr double kMillimetres = 1000.0;
    sightings_.push_back({k, static_cast<float>(line.x()), static_cast<float>(line.y()), static_cast<float>(line.z()),
                          static_cast<float>(kMillimetres * std::sqrt(area)), static_cast<float>(1.0 - cosine)});
  }

  // Groups the sightings by facet (a counting sort keeps the views' order) and reduces each group.
  void measure() {
    std::array<std::uint32_t, kTileFacets + 1> first{};
    for (std::size_t k = 0; k < count_; ++k) first[k + 1] = first[k] + seen_[k];
    const std::size_t total = sightings_.size();
    x_.resize(total);
    y_.resize(total);
    z_.resize(total);
    gsd_.resize(total);
    versine_.resize(total);
    auto next = first;
    for (const Sighting& s : sightings_) {
      const std::uint32_t at = next[s.local]++;
      x_[at] = s.x;
      y_[at] = s.y;
      z_[at] = s.z;
      gsd_[at] = s.gsd_mm;
      versine_[at] = s.versine;
    }
    for (std::size_t k = 0; k < count_; ++k)
      if (seen_[k] > 0) reduce(facet_[k], first[k], seen_[k]);
  }

  void reduce(std::uint32_t facet, std::size_t begin, std::size_t n) {
    float* gsd = gsd_.data() + begin;
    out_.gsd_best_mm[facet] = *std::min_element(gsd, gsd + n);
    std::nth_element(gsd, gsd + (n - 1) / 2, gsd + n);
    out_.gsd_median_mm[facet] = gsd[(n - 1) / 2];
    float best = kLargest, second = kLargest;
    for (std::size_t i = begin; i < begin + n; ++i) {
      second = std::min(second, std::max(best, versine_[i]));
      best = std::min(best, versine_[i]);
    }
    const auto degrees = [](float versine) {
      return static_cast<float>(base::rad_to_deg(2.0 * std::asin(std::sqrt(0.5 * static_cast<double>(versine)))));
    };
    out_.incidence_best_deg[facet] = degrees(best);
    if (n < 2) return;
    out_.incidence_second_deg[facet] = degrees(second);
    out_.parallax_deg[facet] = static_cast<float>(base::rad_to_deg(largest_angle(
        std::span(x_).subspan(begin, n), std::span(y_).subspan(begin, n), std::span(z_).subspan(begin, n), scratch_)));
  }

  const TriangleMesh& mesh_;
  const FacetTiles& tiles_;
  const visibility::Scene& scene_;
  const std::vector<ViewFrustum>& views_;
  const CoverageOptions& options_;
  FacetCoverage& out_;

  std::size_t count_ = 0;
  std::uint64_t rays_ = 0;
  std::array<std::uint32_t, kTileFacets> facet_{}, in_frame_{}, facing_{}, seen_{};
  std::array<double, kTileFacets> cx_{}, cy_{}, cz_{}, nx_{}, ny_{}, nz_{};
  std::array<std::uint8_t, kTileFacets> inside_{}, faces_{}, blocked_{};
  std::array<std::uint16_t, kTileFacets> local_{};
  std::array<Vec3, kTileFacets> target_;
  std::vector<Sighting> sightings_;
  std::vector<float> x_, y_, z_, gsd_, versine_;
  SightLines scratch_;
};

std::vector<ViewFrustum> frusta(const ViewSet& set, const std::vector<CameraBounds>& bounds) {
  std::vector<ViewFrustum> result;
  result.reserve(set.views.size());
  for (const View& view : set.views) {
    const std::string record = "frame " + std::to_string(view.frame.value);
    if (view.camera >= bounds.size())
      throw base::Error(base::ErrorCode::invalid_input, "a view names a camera that is not there")
          .record(record)
          .found(std::to_string(view.camera))
          .allowed("0.." + std::to_string(bounds.size()));
    if (!view.T_world_camera.rotation.allFinite() || !view.T_world_camera.translation.allFinite())
      throw base::Error(base::ErrorCode::invalid_input, "a view's pose is not finite")
          .record(record)
          .hint("Run `cairn check` on the survey.");
    result.push_back(view_frustum(bounds[view.camera], view.T_world_camera));
  }
  return result;
}

}  // namespace

FacetCoverage coverage(const TriangleMesh& mesh, const visibility::Scene& scene, const ViewSet& views,
                       const CoverageOptions& options, base::RunContext& ctx) {
  CoverageOptions checked = options;
  base::validate(base::bind_options(checked), "coverage");
  const std::size_t count = mesh.triangles.size();
  ctx.check_memory(50 * static_cast<std::uint64_t>(count), "coverage of the facets");

  FacetCoverage out;
  out.views.assign(count, 0);
  out.in_frame.assign(count, 0);
  out.facing.assign(count, 0);
  if (options.metrics)
    for (auto* column :
         {&out.gsd_best_mm, &out.gsd_median_mm, &out.incidence_best_deg, &out.incidence_second_deg, &out.parallax_deg})
      column->assign(count, kNone);

  std::vector<CameraBounds> bounds;
  bounds.reserve(views.cameras.size());
  for (const survey::Camera& camera : views.cameras) bounds.push_back(camera_bounds(camera, options.frame_margin));
  const std::vector<ViewFrustum> looking = frusta(views, bounds);

  const FacetTiles tiles = sort_into_tiles(mesh);
  out.skipped = tiles.skipped;
  std::vector<std::uint64_t> rays(tiles.tiles.size(), 0);
  for (std::size_t begin = 0; begin < tiles.tiles.size(); begin += kTilesAtOnce) {
    ctx.check_stop();
    ctx.progress("facet tiles", begin, tiles.tiles.size());
    const std::size_t end = std::min(begin + kTilesAtOnce, tiles.tiles.size());
    base::parallel_for(end - begin, 16, [&](std::size_t from, std::size_t to) {
      TileWork work(mesh, tiles, scene, looking, options, out);
      for (std::size_t t = begin + from; t < begin + to; ++t) {
        const std::uint64_t before = work.rays();
        work.run(tiles.tiles[t]);
        rays[t] = work.rays() - before;
      }
    });
  }
  for (const std::uint64_t n : rays) out.rays += n;
  ctx.progress("facet tiles", tiles.tiles.size(), tiles.tiles.size());
  return out;
}

}  // namespace cairn::coverage
