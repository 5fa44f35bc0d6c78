// A layer's columns as CSV.
#pragma once

#include <filesystem>
#include <string>

#include "io/vector_layer.hpp"

namespace cairn::io {

// RFC 4180 with a header row, "\n" line ends, UTF-8; geometry is not written (tables carry latitude,
// longitude and height as columns). Texts with a comma, quote or line end are quoted. A text that a
// spreadsheet would take for a formula (it starts with = + - @, tab or CR) gets a leading apostrophe.
[[nodiscard]] std::string csv_text(const Layer& layer);
void write_layer_csv(const std::filesystem::path& path, const Layer& layer);

}  // namespace cairn::io
