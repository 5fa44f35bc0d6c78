// GeoJSON by RFC 7946.
#pragma once

#include <filesystem>
#include <string>

#include "io/vector_layer.hpp"

namespace cairn::io {

// CRS84 (longitude, latitude), 7 decimals (1.1 cm: for maps, not for measuring), outer rings
// counter-clockwise and holes clockwise, no "crs" member. Heights (3 decimals) are written only where
// they are ellipsoidal, as the RFC demands; the height columns are there always.
// Throws crs_mismatch for a line or polygon that crosses the antimeridian.
[[nodiscard]] std::string geojson_text(const Layer& layer);
void write_geojson(const std::filesystem::path& path, const Layer& layer);

}  // namespace cairn::io
