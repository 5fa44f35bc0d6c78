// The member `tipping` of a rock's record, in rocks.json and in what fragility writes for one rock.
#pragma once

#include "io/json.hpp"
#include "survey/rock.hpp"

namespace cairn::io {

// Throws invalid_input where a number is not finite; a_qs and v_min of an edge that no push topples are null.
[[nodiscard]] Json to_json(const survey::Tipping& tipping);
// Members that only newer versions write may be missing.
[[nodiscard]] survey::Tipping tipping_from_json(const Json& json);

// A quantile is null where that many of the draws are never toppled by a push.
[[nodiscard]] Json to_json(const survey::Quantiles& quantiles);
// {name: value, ..} in order, and back.
[[nodiscard]] Json named_values_to_json(const std::vector<survey::NamedValue>& values);
[[nodiscard]] std::vector<survey::NamedValue> named_values_from_json(const Json& json);

}  // namespace cairn::io
