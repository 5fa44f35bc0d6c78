// Parameters with which Nav2 loads a map as a keep-out mask.
#pragma once

#include <filesystem>
#include <string>

namespace cairn::io {

// PATH: a ROS 2 parameter file for the nodes `filter_mask_server` (nav2_map_server), `costmap_filter_info_server` and
// for the costmaps' `keepout_filter`. mask: name of the mask's YAML, relative to the file. Type 0 = keep-out; value =
// base + multiplier * mask with base 0 and multiplier 1. Nav2 does not inflate a mask by itself. Throws
// resource_exhausted where it cannot be written.
void write_keepout_parameters(const std::filesystem::path& path, const std::string& mask);

}  // namespace cairn::io
