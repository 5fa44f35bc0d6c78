// mission.json: a planned flight, complete.
#pragma once

#include <filesystem>

#include "io/json.hpp"
#include "survey/mission.hpp"

namespace cairn::io {

inline constexpr int kMissionSchemaVersion = 1;

[[nodiscard]] Json to_json(const survey::Mission& mission);
// `name` stands for the file in messages.
[[nodiscard]] survey::Mission mission_from_json(const Json& json, std::string_view name);

// Written straight to `path`; what was read reads back bit for bit. Throws resource_exhausted where a write fails,
// invalid_input where a number is not finite.
void write_mission(const std::filesystem::path& path, const survey::Mission& mission);
// Throws invalid_input with file and record: a missing member, an unknown kind or role, ids that do not ascend, a
// trajectory of segments without duration.
[[nodiscard]] survey::Mission read_mission(const std::filesystem::path& path);

// Whether a file looks like one: JSON of an object with "mission" among its first bytes.
[[nodiscard]] bool is_mission_file(const std::filesystem::path& path);

}  // namespace cairn::io
