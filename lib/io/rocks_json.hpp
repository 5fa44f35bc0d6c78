// rocks.json: candidate rocks cut from the cloud, with mass properties and tipping.
#pragma once

#include <filesystem>
#include <vector>

#include "io/json.hpp"
#include "survey/manifest.hpp"
#include "survey/rock.hpp"

namespace cairn::io {

struct RocksFile {
  survey::Origin frame;  // the local ENU frame of every coordinate
  std::vector<survey::Rock> rocks;
};

[[nodiscard]] Json to_json(const survey::Rock& rock);
[[nodiscard]] survey::Rock rock_from_json(const Json& json);

// Written straight to `path`; reads back bit for bit. Throws resource_exhausted where a write fails,
// invalid_input where a number is not finite.
void write_rocks(const std::filesystem::path& path, const RocksFile& file);
// Throws invalid_input with file and rock: a missing member, an unknown grade or cap, a duplicate id.
[[nodiscard]] RocksFile read_rocks(const std::filesystem::path& path);

}  // namespace cairn::io
