#include "pipeline/costmap_products.hpp"

#include <algorithm>
#include <utility>

#include "base/error.hpp"
#include "ground/costmap.hpp"
#include "io/keepout.hpp"

namespace cairn::pipeline {
namespace {

constexpr std::size_t kMostCogCells = std::size_t{1} << 26U;
constexpr std::size_t kMostMapCells = std::size_t{1} << 31U;

}  // namespace

std::array<std::uint8_t, 256> graded_occupancy() {
  std::array<std::uint8_t, 256> table{};
  for (std::size_t cost = 1; cost < 253; ++cost) table[cost] = static_cast<std::uint8_t>(1 + 97 * (cost - 1) / 251);
  table[ground::kInscribed] = 99;
  table[ground::kLethal] = 100;
  table[ground::kUnknown] = io::kOccupancyUnknown;
  return table;
}

CostmapProducts::CostmapProducts(std::filesystem::path out, const geometry::GridGeometry& map,
                                 std::vector<CostmapBand> bands, std::string crs, io::MapMode mode,
                                 std::optional<io::MapGeoreference> place)
    : out_(std::move(out)),
      map_(map),
      bands_(std::move(bands)),
      crs_(std::move(crs)),
      mode_(mode),
      place_(std::move(place)),
      has_maps_(map.columns <= kMostMapCells / std::max<std::size_t>(1, map.rows)),
      graded_(graded_occupancy()) {
  if (map.columns > kMostCogCells / std::max<std::size_t>(1, map.rows)) {
    std::vector<io::ByteBand> named;
    for (const auto& band : bands_) named.push_back({band.name, "", band.description});
    writer_ = std::make_unique<io::RasterWriter>(out_ / "costmap.tif", map, named, ground::kUnknown, crs_);
  } else {
    kept_.assign(bands_.size(), geometry::Grid<std::uint8_t>(map, 0));
  }
  if (!has_maps_) return;
  io::RosMap ros;
  ros.occupancy.geometry = map;
  ros.mode = mode_;
  if (mode_ == io::MapMode::scale) {
    if (streams())
      throw base::Error(base::ErrorCode::invalid_argument, "a map too large for mode scale")
          .found(std::to_string(map.columns) + " x " + std::to_string(map.rows))
          .allowed("2^26 cells")
          .hint("Use --map-mode raw, or cut the map with --extent");
    scale_map_ = ros;
  } else {
    map_writer_ = std::make_unique<io::RosMapWriter>(out_, "map", ros, place_);
  }
  ros.mode = io::MapMode::trinary;
  keepout_writer_ = std::make_unique<io::RosMapWriter>(out_, "keepout", ros, place_);
}

std::uint64_t CostmapProducts::kept_bytes() const {
  // The COG itself is built in memory too: with its overviews at most one and a third of the bands.
  return streams() ? 0 : 7 * map_.cells() * bands_.size() / 3;
}

void CostmapProducts::rows(std::size_t rows, const std::vector<std::vector<std::uint8_t>>& bands,
                           const std::vector<std::uint8_t>& keepout) {
  const std::size_t cells = rows * map_.columns, done = rows_done_ * map_.columns;
  if (writer_) {
    std::vector<const std::uint8_t*> pointers;
    for (const auto& band : bands) pointers.push_back(band.data());
    writer_->rows(rows, pointers);
  } else {
    for (std::size_t b = 0; b < bands.size(); ++b)
      std::copy_n(bands[b].begin(), cells, kept_[b].values.begin() + static_cast<std::ptrdiff_t>(done));
  }
  if (has_maps_) {
    if (mode_ == io::MapMode::trinary) {
      map_writer_->rows(std::span(bands[1]).first(cells));
    } else {
      std::vector<std::uint8_t> graded(cells);
      std::transform(bands[0].begin(), bands[0].begin() + static_cast<std::ptrdiff_t>(cells), graded.begin(),
                     [&](std::uint8_t cost) { return graded_[cost]; });
      if (scale_map_)
        scale_map_->occupancy.values.insert(scale_map_->occupancy.values.end(), graded.begin(), graded.end());
      else map_writer_->rows(graded);
    }
    keepout_writer_->rows(std::span(keepout).first(cells));
  }
  rows_done_ += rows;
}

void CostmapProducts::finish() {
  if (writer_) {
    writer_->finish();
  } else {
    std::vector<io::RasterBand> named;
    for (std::size_t b = 0; b < bands_.size(); ++b)
      named.push_back({bands_[b].name, "", bands_[b].description, std::move(kept_[b]), ground::kUnknown});
    io::write_cog(out_ / "costmap.tif", named, crs_);
  }
  if (!has_maps_) return;
  if (scale_map_) io::write_ros_map(out_, "map", *scale_map_, place_);
  else map_writer_->finish();
  keepout_writer_->finish();
  io::write_keepout_parameters(out_ / "keepout_params.yaml", "keepout.yaml");
}

}  // namespace cairn::pipeline
