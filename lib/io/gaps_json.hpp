// gaps.json: the parts of the surface that the flight did not see well enough.
#pragma once

#include <filesystem>
#include <vector>

#include "io/json.hpp"
#include "survey/coverage_gap.hpp"
#include "survey/manifest.hpp"

namespace cairn::io {

struct GapsFile {
  survey::Origin frame;  // the local ENU frame of every coordinate
  std::vector<survey::CoverageGap> gaps;
};

[[nodiscard]] Json to_json(const survey::CoverageGap& gap);
[[nodiscard]] survey::CoverageGap gap_from_json(const Json& json);

// Written straight to `path`; reads back bit for bit. Throws resource_exhausted where a write fails,
// invalid_input where a number is not finite.
void write_gaps(const std::filesystem::path& path, const GapsFile& file);
// Throws invalid_input with file and gap: a missing member, a ring of fewer than 3 vertices, a
// duplicate id.
[[nodiscard]] GapsFile read_gaps(const std::filesystem::path& path);

}  // namespace cairn::io
