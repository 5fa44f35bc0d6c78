// Numbers to text and back, independent of locale.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace cairn::base {

// Shortest text that reads back to the same double ("0.1", "1e+20"); "nan", "inf", "-inf".
// Negative zero is written "0".
[[nodiscard]] std::string to_text(double value);
// Fixed number of decimals, rounded; negative zero is written without its sign.
[[nodiscard]] std::string to_fixed(double value, int decimals);

// The whole text must be one number; surrounding blanks and a leading '+' are accepted.
// Texts that spell infinity or nan give those values: check with std::isfinite.
[[nodiscard]] std::optional<double> parse_real(std::string_view text);
[[nodiscard]] std::optional<std::int64_t> parse_integer(std::string_view text);

// Text without leading and trailing blanks, tabs and line ends.
[[nodiscard]] std::string_view trim(std::string_view text);

}  // namespace cairn::base
