// Published fragility models as JSON data files.
#pragma once

#include <filesystem>

#include "survey/fragility_model.hpp"

namespace cairn::io {

// Members: name, reference, doi, form, im, coefficients (object, may be empty), valid (object of [least, greatest]),
// entered_by, checked_against. Throws invalid_input for a missing or unknown member, a bound that descends, and for
// coefficients that do not say who entered them and what they were checked against.
[[nodiscard]] survey::FragilityModel read_fragility_model(const std::filesystem::path& path);

}  // namespace cairn::io
