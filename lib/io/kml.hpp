// KML 2.2 for Google Earth and the like.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "io/vector_layer.hpp"

namespace cairn::io {

// One folder a layer; placemarks are named by `name_column` where the layer has it.
// KML's absolute heights are EGM96 sea level: ellipsoidal heights are converted (else rocks float or
// sink by the undulation), orthometric heights of egm96 are written as they are; with any other height
// type the features are clamped to the ground and the folder's description says so.
// Colours follow the layer's style. Throws crs_mismatch where the geoid's grid is not installed.
[[nodiscard]] std::string kml_text(const std::vector<Layer>& layers, const std::string& document_name,
                                   const std::string& name_column = "name");
void write_kml(const std::filesystem::path& path, const std::vector<Layer>& layers, const std::string& document_name,
               const std::string& name_column = "name");

}  // namespace cairn::io
