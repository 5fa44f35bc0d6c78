// PCD point clouds (Point Cloud Library), by our own reader and writer in double precision.
#pragma once

#include <filesystem>

#include "io/source_facts.hpp"

namespace cairn::io {

// Versions .5 to .7; ascii, binary and binary_compressed (LZF, unpacked by ourselves). Fields, in any
// case: x y z; normal_x normal_y normal_z; rgb or rgba packed in four bytes, or red green blue;
// intensity (integer), classification (one byte), gps_time; the others become scalar columns,
// counts above 1 as name_0, name_1, ... The viewpoint is kept as a comment and not applied.
// Throws invalid_input with the byte or line.
[[nodiscard]] CloudData read_pcd(const std::filesystem::path& path);

// Version 0.7, binary, positions in double; colours packed as PCL does it; scalars keep their type.
// Throws invalid_argument where a coordinate is not finite.
void write_pcd(const std::filesystem::path& path, const geometry::PointCloud& cloud);

}  // namespace cairn::io
