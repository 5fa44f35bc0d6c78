// The plane that a costmap lies in: a survey's local frame, or the CRS of a prior map.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "geometry/vec.hpp"
#include "survey/manifest.hpp"

namespace cairn::pipeline {

class MapPlane {
 public:
  // Each names the plane, or proves that a file lies in it. The first one fixes it; a later one that differs by more
  // than a centimetre a kilometre throws crs_mismatch with `file`.
  void join_frame(const survey::Origin& origin, const std::filesystem::path& file);
  // crs: WKT of a raster, "" or an engineering CRS = it does not say where (nothing happens). Throws crs_mismatch where
  // it is not in metres.
  void join_crs(const std::string& crs, const std::filesystem::path& file);

  [[nodiscard]] bool known() const { return !crs_.empty(); }
  // WKT for rasters: an engineering CRS in metres where the place on Earth is not known.
  [[nodiscard]] std::string raster_crs() const;
  // Set where a survey's frame is known.
  [[nodiscard]] const std::optional<survey::Origin>& origin() const { return origin_; }
  // The same, or the latitude and longitude of (0, 0) where only a CRS is known; empty where nothing is.
  [[nodiscard]] std::optional<survey::Origin> place_of_zero() const;

  // From the positions of a layer (points and rings' vertices) to the plane. Throws crs_mismatch where the layer or the
  // plane has no CRS, and, when called, where a position lies outside either.
  using Projection = std::function<std::vector<geometry::Vec2>(std::vector<geometry::Vec3>)>;
  [[nodiscard]] Projection projection(const std::string& crs, const std::filesystem::path& file) const;

 private:
  std::string crs_;
  std::filesystem::path named_by_;
  std::optional<survey::Origin> origin_;
};

}  // namespace cairn::pipeline
