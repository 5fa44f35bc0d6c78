// The front door for point clouds: any format, recognised by its content.
#pragma once

#include <filesystem>
#include <optional>

#include "io/las.hpp"
#include "io/source_facts.hpp"

namespace cairn::io {

enum class CloudFormat { las, ply, pcd, obj, xyz };

// By the first bytes, else by the extension. Throws invalid_input with the formats that are read;
// compressed LAS (LAZ, COPC) and E57 are named as such, with a remedy.
[[nodiscard]] CloudFormat recognise_cloud(const std::filesystem::path& path);

struct CloudFile : CloudData {
  std::optional<LasMetadata> las;  // where the file is LAS: pass it to write_las to keep scale, offset, records
};

// Coordinates in the file's own CRS and units (facts.crs; "" = none declared). A file with 0
// points gives an empty cloud: whether that is an error is the caller's to say.
[[nodiscard]] CloudFile read_cloud(const std::filesystem::path& path, const LasColumns& columns = {});

struct CloudWriteOptions {
  std::string crs;      // "EPSG:n" or WKT; PCD and XYZ cannot hold one
  std::string crs_wkt;  // for LAS 1.4, where crs is an EPSG code
  const LasMetadata* las = nullptr;
};
// By the extension of `path`: .las, .ply, .pcd, .xyz, .txt or .csv. Writes straight to `path`.
void write_cloud(const std::filesystem::path& path, const geometry::PointCloud& cloud,
                 const CloudWriteOptions& options = {});

}  // namespace cairn::io
