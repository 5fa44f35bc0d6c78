// A planned flight as map layers: for KML, GeoJSON and CSV.
#pragma once

#include <string>

#include "io/vector_layer.hpp"
#include "survey/mission.hpp"

namespace cairn::io {

// Points in order of flight, with headings 0..360.
[[nodiscard]] Layer waypoint_layer(const survey::Mission& mission);
// One line through the waypoints.
[[nodiscard]] Layer path_layer(const survey::Mission& mission);
// Images to be taken: position and direction.
[[nodiscard]] Layer view_layer(const survey::Mission& mission);

// One FeatureCollection (RFC 7946) with path, waypoints and views, told apart by their property "layer"; the member
// "name" says DRAFT.
[[nodiscard]] std::string mission_geojson(const survey::Mission& mission);

}  // namespace cairn::io
