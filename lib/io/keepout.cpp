#include "io/keepout.hpp"

#include "base/atomic_file.hpp"

namespace cairn::io {

void write_keepout_parameters(const std::filesystem::path& path, const std::string& mask) {
  // Both costmaps of Nav2 take the same filter.
  const auto costmap = [](const std::string& name) {
    return name + ":\n  " + name +
           ":\n    ros__parameters:\n"
           "      filters: [\"keepout_filter\"]\n"
           "      keepout_filter:\n"
           "        plugin: \"nav2_costmap_2d::KeepoutFilter\"\n"
           "        enabled: true\n"
           "        filter_info_topic: \"/costmap_filter_info\"\n";
  };
  base::write_file(path,
                   "# Keep-out mask for Nav2: give this file to nav2_map_server's filter_mask_server and\n"
                   "# costmap_filter_info_server, and merge the costmaps' part into the robot's own parameters.\n"
                   "filter_mask_server:\n"
                   "  ros__parameters:\n"
                   "    frame_id: \"map\"\n"
                   "    topic_name: \"/keepout_filter_mask\"\n"
                   "    yaml_filename: \"" +
                       mask +
                       "\"\n"
                       "costmap_filter_info_server:\n"
                       "  ros__parameters:\n"
                       "    type: 0\n"
                       "    filter_info_topic: \"/costmap_filter_info\"\n"
                       "    mask_topic: \"/keepout_filter_mask\"\n"
                       "    base: 0.0\n"
                       "    multiplier: 1.0\n" +
                       costmap("global_costmap") + costmap("local_costmap"));
}

}  // namespace cairn::io
