// The kinds of files that `info` knows, one describing function each. Internal to info.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "geometry/primitives.hpp"
#include "io/json.hpp"
#include "pipeline/info.hpp"

namespace cairn::pipeline::info {

using Describe = io::Json (*)(const std::filesystem::path&, const InfoOptions&);

io::Json describe_las(const std::filesystem::path& path, const InfoOptions& options);
io::Json describe_cloud(const std::filesystem::path& path, const InfoOptions& options);
// PLY and OBJ: a mesh where the file has faces, else a cloud.
io::Json describe_mesh_or_cloud(const std::filesystem::path& path, const InfoOptions& options);
io::Json describe_mesh(const std::filesystem::path& path, const InfoOptions& options);
io::Json describe_raster(const std::filesystem::path& path, const InfoOptions& options);
io::Json describe_vector(const std::filesystem::path& path, const InfoOptions& options);
io::Json describe_ros_map(const std::filesystem::path& path, const InfoOptions& options);
io::Json describe_image(const std::filesystem::path& path, const InfoOptions& options);
io::Json describe_json(const std::filesystem::path& path, const InfoOptions& options);
io::Json describe_survey(const std::filesystem::path& path, const InfoOptions& options);
io::Json describe_colmap(const std::filesystem::path& path, const InfoOptions& options);
io::Json describe_run(const std::filesystem::path& path, const InfoOptions& options);

// The start of every description.
[[nodiscard]] io::Json begin(const std::filesystem::path& path, std::string_view kind, std::string_view format);
// {"min": [..], "max": [..]}, null where empty.
[[nodiscard]] io::Json to_json(const geometry::Box3& box);
// What PROJ says of a CRS text: null where there is none. A text that PROJ cannot read is a warning.
[[nodiscard]] io::Json crs_json(const std::string& crs, std::vector<std::string>& warnings);

}  // namespace cairn::pipeline::info
