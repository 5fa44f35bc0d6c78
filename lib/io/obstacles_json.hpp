// obstacles.json: what a ground vehicle must not drive into.
#pragma once

#include <filesystem>
#include <vector>

#include "io/json.hpp"
#include "survey/manifest.hpp"
#include "survey/obstacle.hpp"

namespace cairn::io {

struct ObstaclesFile {
  survey::Origin frame;  // the local ENU frame of every coordinate
  std::vector<survey::Obstacle> obstacles;
};

[[nodiscard]] Json to_json(const survey::Obstacle& obstacle);
[[nodiscard]] survey::Obstacle obstacle_from_json(const Json& json);

// Written straight to `path`; reads back bit for bit. Throws resource_exhausted where a write fails,
// invalid_input where a number is not finite.
void write_obstacles(const std::filesystem::path& path, const ObstaclesFile& file);
// Throws invalid_input with file and obstacle: a missing member, an unknown kind, a duplicate target.
[[nodiscard]] ObstaclesFile read_obstacles(const std::filesystem::path& path);

}  // namespace cairn::io
