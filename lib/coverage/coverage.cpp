#include "coverage/coverage.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

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
constexpr float kLeastCosine = 1e-7F;      // keeps the sampling distance of a grazing view finite
constexpr float kLeastDepth = 1e-12F;      // m; keeps what a fisheye sees beside itself finite
constexpr float kLeastHorizontal = 1e-6F;  // of the vertical: below that a view has no azimuth
constexpr unsigned kAzimuths = 0xFFFU;     // twelve bins
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

// The facets of one tile, by component, and room to work in.
class TileWork {
 public:
  TileWork(const TriangleMesh& mesh, const FacetTiles& tiles, const visibility::Scene& scene,
           const std::vector<ViewFrustum>& views, const std::vector<ViewNoise>& noise, const CoverageOptions& options,
           FacetCoverage& out)
      : mesh_(mesh), tiles_(tiles), scene_(scene), views_(views), noise_(noise), options_(options), out_(out) {}

  void run(const FacetTile& tile) {
    load(tile);
    candidates_.clear();
    for (const ViewFrustum& view : views_) {
      const Side side = side_of(view, tile);
      if (side != Side::outside) candidates_.emplace_back(&view, side);
    }
    if (options_.metrics) reserve_lines();
    for (const auto& [view, side] : candidates_) look(*view, side);
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
      azimuths_[k] = 0;
    }
    for (auto& row : information_) row.fill(0.0);
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
    std::size_t visible = 0;
    for (std::size_t i = 0; i < n; ++i)
      if (blocked_[i] == 0) local_[visible++] = local_[i];
    if (options_.metrics) note(view, visible);
    for (std::size_t i = 0; i < visible; ++i) ++seen_[local_[i]];
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
      inside_[k] = least >= 0.0 && (depth > 0.0 || !view.bounds->bounded) ? 1 : 0;
    }
  }

  // A row of sight lines for each facet, as long as the list of views that may see it.
  void reserve_lines() {
    stride_ = candidates_.size();
    for (auto* column : {&x_, &y_, &z_, &gsd_, &versine_}) column->resize(count_ * stride_);
  }

  // Adds this view to the rows of the facets local_[0..n).
  void note(const ViewFrustum& view, std::size_t n) {
    const survey::Camera& camera = view.bounds->camera;
    const Eigen::Vector3f depth = view.R_camera_world.row(2).cast<float>();
    for (std::size_t i = 0; i < n; ++i) {
      const std::uint16_t k = local_[i];
      dx_[i] = static_cast<float>(view.centre.x() - cx_[k]);
      dy_[i] = static_cast<float>(view.centre.y() - cy_[k]);
      dz_[i] = static_cast<float>(view.centre.z() - cz_[k]);
      mx_[i] = static_cast<float>(nx_[k]);
      my_[i] = static_cast<float>(ny_[k]);
      mz_[i] = static_cast<float>(nz_[k]);
    }
    constexpr double kMillimetres = 1000.0;
    const auto scale = static_cast<float>(kMillimetres / std::sqrt(camera.fx_px * camera.fy_px));
    for (std::size_t i = 0; i < n; ++i) {
      const float inverse = 1.0F / std::sqrt(dx_[i] * dx_[i] + dy_[i] * dy_[i] + dz_[i] * dz_[i]);
      const float z = -(depth.x() * dx_[i] + depth.y() * dy_[i] + depth.z() * dz_[i]);
      lx_[i] = dx_[i] * inverse;
      ly_[i] = dy_[i] * inverse;
      lz_[i] = dz_[i] * inverse;
      // Half the squared chord from normal to sight line: keeps its digits near normal incidence.
      const float ex = lx_[i] - mx_[i], ey = ly_[i] - my_[i], ez = lz_[i] - mz_[i];
      const float versine = 0.5F * (ex * ex + ey * ey + ez * ez);
      const float cosine = 1.0F - versine > kLeastCosine ? 1.0F - versine : kLeastCosine;
      lv_[i] = versine;
      lg_[i] = scale * std::sqrt(z * z * z * inverse / cosine);
    }
    std::fill_n(lm_.begin(), n, 1.0F);
    if (!view.bounds->exact)
      for (std::size_t i = 0; i < n; ++i) {
        const std::uint16_t k = local_[i];
        const Vec3 p = view.R_camera_world * (Vec3(cx_[k], cy_[k], cz_[k]) - view.centre);
        lm_[i] = static_cast<float>(view.bounds->magnification(p.x() / p.z(), p.y() / p.z()));
        lg_[i] /= std::sqrt(lm_[i]);
      }
    inform(view, n);
    azimuth(n);
    for (std::size_t i = 0; i < n; ++i) {
      const std::size_t at = local_[i] * stride_ + seen_[local_[i]];
      x_[at] = lx_[i];
      y_[at] = ly_[i];
      z_[at] = lz_[i];
      gsd_[at] = lg_[i];
      versine_[at] = lv_[i];
      azimuths_[local_[i]] =
          static_cast<std::uint16_t>(azimuths_[local_[i]] | ((1U << static_cast<unsigned>(lb_[i])) & kAzimuths));
    }
    if (n == count_) {  // local_ counts up from 0
      for (std::size_t q = 0; q < 6; ++q)
        for (std::size_t k = 0; k < n; ++k) information_[q][k] += static_cast<double>(li_[q][k]);
    } else {
      for (std::size_t q = 0; q < 6; ++q)
        for (std::size_t i = 0; i < n; ++i) information_[q][local_[i]] += static_cast<double>(li_[q][i]);
    }
  }

  // li_: information of the sight lines, see point_sigma().
  void inform(const ViewFrustum& view, std::size_t n) {
    const ViewNoise& noise = noise_[static_cast<std::size_t>(&view - views_.data())];
    const geometry::Mat3& R = view.R_camera_world;
    const Eigen::Vector3f r1 = R.row(0).cast<float>(), r2 = R.row(1).cast<float>(), r3 = R.row(2).cast<float>();
    const auto fx = static_cast<float>(view.bounds->camera.fx_px), fy = static_cast<float>(view.bounds->camera.fy_px);
    const float ax = r1.x(), ay = r1.y(), az = r1.z(), bx = r2.x(), by = r2.y(), bz = r2.z(), cx = r3.x(), cy = r3.y(),
                cz = r3.z();
    const float pixel = noise.pixel_px2, level = noise.xy_m2, up = noise.z_m2, turn = noise.rotation_rad2;
    for (std::size_t i = 0; i < n; ++i) {
      const float x = dx_[i], y = dy_[i], z = dz_[i];
      const float depth = -(cx * x + cy * y + cz * z);
      const float inverse = 1.0F / (std::abs(depth) + kLeastDepth);
      const float u = -(ax * x + ay * y + az * z) * inverse, v = -(bx * x + by * y + bz * z) * inverse;
      const float m = std::sqrt(lm_[i]), f = fx * m * inverse, g = fy * m * inverse;
      const float px = f * (ax - u * cx), py = f * (ay - u * cy), pz = f * (az - u * cz);
      const float qx = g * (bx - v * cx), qy = g * (by - v * cy), qz = g * (bz - v * cz);
      const float turned = turn * (x * x + y * y + z * z);
      const float sl = level + turned, su = up + turned;
      const float s11 = pixel + sl * (px * px + py * py) + su * pz * pz;
      const float s22 = pixel + sl * (qx * qx + qy * qy) + su * qz * qz;
      const float s12 = sl * (px * qx + py * qy) + su * pz * qz;
      const float det = 1.0F / (s11 * s22 - s12 * s12);
      const float w11 = s22 * det, w22 = s11 * det, w12 = -s12 * det;
      const float ex = w11 * px + w12 * qx, ey = w11 * py + w12 * qy, ez = w11 * pz + w12 * qz;
      const float hx = w12 * px + w22 * qx, hy = w12 * py + w22 * qy, hz = w12 * pz + w22 * qz;
      li_[0][i] = px * ex + qx * hx;
      li_[1][i] = px * ey + qx * hy;
      li_[2][i] = px * ez + qx * hz;
      li_[3][i] = py * ey + qy * hy;
      li_[4][i] = py * ez + qy * hz;
      li_[5][i] = pz * ez + qz * hz;
    }
  }

  // lb_: the bin of the sight line's azimuth, 12 where it has none.
  void azimuth(std::size_t n) {
    constexpr float kTan30 = 0.57735027F, kTan60 = 1.7320508F;
    for (std::size_t i = 0; i < n; ++i) {
      const float east = std::abs(dx_[i]), north = std::abs(dy_[i]);
      const int k = (east >= kTan30 * north ? 1 : 0) + (east >= kTan60 * north ? 1 : 0);
      const int eastern = dy_[i] >= 0.0F ? k : 5 - k, western = dy_[i] < 0.0F ? 6 + k : 11 - k;
      const int bin = dx_[i] >= 0.0F ? eastern : western;
      lb_[i] = east + north > kLeastHorizontal * std::abs(dz_[i]) ? bin : 12;
    }
  }

  void measure() {
    for (std::size_t k = 0; k < count_; ++k)
      if (seen_[k] > 0) {
        reduce(facet_[k], k * stride_, seen_[k]);
        out_.azimuths[facet_[k]] = azimuths_[k];
        if (seen_[k] > 1) predict(k);
      }
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
    float* versine = versine_.data() + begin;
    std::nth_element(versine, versine + (n - 1) / 2, versine + n);
    out_.incidence_median_deg[facet] = degrees(versine[(n - 1) / 2]);
    if (n < 2) return;
    out_.incidence_second_deg[facet] = degrees(second);
    const WidestAngles widest = widest_angles(std::span(x_).subspan(begin, n), std::span(y_).subspan(begin, n),
                                              std::span(z_).subspan(begin, n), scratch_);
    out_.parallax_deg[facet] = static_cast<float>(base::rad_to_deg(widest.first));
    out_.parallax_second_deg[facet] = static_cast<float>(base::rad_to_deg(widest.second));
  }

  void predict(std::size_t k) {
    const std::uint32_t facet = facet_[k];
    Information information;
    for (std::size_t q = 0; q < 6; ++q) information[q] = information_[q][k];
    constexpr double kMillimetres = 1000.0;
    const PointSigma sigma = point_sigma(information);
    out_.sigma_max_mm[facet] = static_cast<float>(kMillimetres * sigma.largest_m);
    out_.sigma_z_mm[facet] = static_cast<float>(kMillimetres * sigma.up_m);
  }

  const TriangleMesh& mesh_;
  const FacetTiles& tiles_;
  const visibility::Scene& scene_;
  const std::vector<ViewFrustum>& views_;
  const std::vector<ViewNoise>& noise_;
  const CoverageOptions& options_;
  FacetCoverage& out_;

  std::size_t count_ = 0;
  std::uint64_t rays_ = 0;
  std::array<std::uint32_t, kTileFacets> facet_{}, in_frame_{}, facing_{}, seen_{};
  std::array<double, kTileFacets> cx_{}, cy_{}, cz_{}, nx_{}, ny_{}, nz_{};
  std::array<std::uint8_t, kTileFacets> inside_{}, faces_{}, blocked_{};
  std::array<std::uint16_t, kTileFacets> local_{};
  std::array<Vec3, kTileFacets> target_;
  std::array<float, kTileFacets> dx_{}, dy_{}, dz_{}, mx_{}, my_{}, mz_{}, lx_{}, ly_{}, lz_{}, lv_{}, lg_{}, lm_{};
  std::array<std::array<float, kTileFacets>, 6> li_{};
  std::array<int, kTileFacets> lb_{};
  std::array<std::uint16_t, kTileFacets> azimuths_{};
  std::array<std::array<double, kTileFacets>, 6> information_{};
  std::vector<std::pair<const ViewFrustum*, Side>> candidates_;
  std::size_t stride_ = 0;
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
  ctx.check_memory(70 * static_cast<std::uint64_t>(count), "coverage of the facets");

  FacetCoverage out;
  out.views.assign(count, 0);
  out.in_frame.assign(count, 0);
  out.facing.assign(count, 0);
  if (options.metrics)
    for (auto* column :
         {&out.gsd_best_mm, &out.gsd_median_mm, &out.incidence_best_deg, &out.incidence_second_deg,
          &out.incidence_median_deg, &out.parallax_deg, &out.parallax_second_deg, &out.sigma_max_mm, &out.sigma_z_mm})
      column->assign(count, kNone);
  if (options.metrics) out.azimuths.assign(count, 0);

  std::vector<CameraBounds> bounds;
  bounds.reserve(views.cameras.size());
  for (const survey::Camera& camera : views.cameras) bounds.push_back(camera_bounds(camera, options.frame_margin));
  const std::vector<ViewFrustum> looking = frusta(views, bounds);

  std::vector<ViewNoise> noise;
  noise.reserve(views.views.size());
  for (const View& view : views.views) noise.push_back(view_noise(view, options.noise));

  const FacetTiles tiles = sort_into_tiles(mesh);
  out.skipped = tiles.skipped;
  std::vector<std::uint64_t> rays(tiles.tiles.size(), 0);
  for (std::size_t begin = 0; begin < tiles.tiles.size(); begin += kTilesAtOnce) {
    ctx.check_stop();
    ctx.progress("facet tiles", begin, tiles.tiles.size());
    const std::size_t end = std::min(begin + kTilesAtOnce, tiles.tiles.size());
    base::parallel_for(end - begin, 16, [&](std::size_t from, std::size_t to) {
      TileWork work(mesh, tiles, scene, looking, noise, options, out);
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
