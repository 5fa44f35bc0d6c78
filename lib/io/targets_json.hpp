// targets.json: what `locate` found.
#pragma once

#include <filesystem>
#include <vector>

#include "io/json.hpp"
#include "survey/manifest.hpp"
#include "survey/target.hpp"

namespace cairn::io {

struct TargetsFile {
  survey::Origin frame;  // the local ENU frame of every coordinate
  std::vector<survey::Target> targets;

  [[nodiscard]] const survey::Target* find(survey::TargetId id) const;
};

[[nodiscard]] Json to_json(const survey::Target& target);
[[nodiscard]] survey::Target target_from_json(const Json& json);

// Written straight to `path`; reads back bit for bit. Throws resource_exhausted where a write fails,
// invalid_input where a number is not finite.
void write_targets(const std::filesystem::path& path, const TargetsFile& file);
// Throws invalid_input with file and target: a missing member, an unknown state, a duplicate id.
[[nodiscard]] TargetsFile read_targets(const std::filesystem::path& path);

}  // namespace cairn::io
