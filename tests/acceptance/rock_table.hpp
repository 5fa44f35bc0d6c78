// Tables of many simulated rocks and scenes.
#pragma once

#include <string>
#include <vector>

#include "io/json.hpp"

namespace cairn::acceptance {

// Markdown of the lines that run_rock and run_scene give: all rocks not held out, those of the held-out family, by
// family, by what hid the contact and by hidden share; then repeatability, where one seed was sampled several times;
// then scenes. Figures stand with 95 % intervals over rocks (bootstrap; Wilson for shares).
[[nodiscard]] std::string rock_tables(const std::vector<io::Json>& lines);

}  // namespace cairn::acceptance
