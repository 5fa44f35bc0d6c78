#include "io/ros_map.hpp"

#include "base/error.hpp"
#include "io/json.hpp"

namespace cairn::io {
namespace {

using base::Error;
using base::ErrorCode;

}  // namespace

std::string_view name_of(MapMode mode) {
  switch (mode) {
    case MapMode::trinary: return "trinary";
    case MapMode::scale: return "scale";
    case MapMode::raw: return "raw";
  }
  return "trinary";
}

MapGeoreference read_map_georeference(const std::filesystem::path& path) {
  const Json json = read_json(path);
  try {
    MapGeoreference out;
    const Json& origin = json.at("origin");
    out.origin = {origin.at("latitude_deg").as_real(), origin.at("longitude_deg").as_real(),
                  origin.at("height_m").as_real()};
    const auto type = survey::height_type_from(origin.at("height_type").as_string());
    if (!type)
      throw Error(ErrorCode::invalid_input, "an unknown height type")
          .found("'" + origin.at("height_type").as_string() + "'");
    out.height_type = *type;
    out.geoid = origin.at("geoid").as_string();
    out.crs_wkt = json.at("crs_wkt").as_string();
    return out;
  } catch (Error& error) {
    error.default_file(path.string());
    throw;
  }
}

}  // namespace cairn::io
