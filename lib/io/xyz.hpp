// Point clouds as text: XYZ, CSV and the like.
#pragma once

#include <filesystem>
#include <string_view>

#include "io/source_facts.hpp"

namespace cairn::io {

// One point a line; separated by comma, semicolon, tab or blanks. Lines that start with '#' or '//' are comments;
// a first line with a word that is no number (or the last comment before the data, where it has
// as many words as the data has columns) names the columns: x y z (also easting northing elevation,
// height), r g b, nx ny nz, intensity, classification; the others become scalar columns. Without
// names the first three columns are x y z and the others "column_4", ...
// Throws invalid_input with the line.
[[nodiscard]] CloudData read_xyz(const std::filesystem::path& path);

// Whether the start of a text looks like such a file: some first line is three or more numbers or
// names x, y and z.
[[nodiscard]] bool looks_like_xyz(std::string_view head);

// Comma-separated with a header line: x,y,z and all other columns; coordinates in shortest round-trip form.
void write_xyz(const std::filesystem::path& path, const geometry::PointCloud& cloud);

}  // namespace cairn::io
