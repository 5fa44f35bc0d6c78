// Instants: int64 nanoseconds on a declared base.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace cairn::base {

// Two logs of different base are joined only with an explicit offset.
enum class TimeBase { utc, gps, boot, unknown };

[[nodiscard]] std::string_view name_of(TimeBase base);
[[nodiscard]] std::optional<TimeBase> time_base_from(std::string_view name);

// Nanoseconds since 1970-01-01 of a civil time without leap seconds.
// Ranges: month 1..12, day 1..31, hour 0..23, minute 0..59, second 0..60 (fraction kept).
// Empty where a field is out of range.
[[nodiscard]] std::optional<std::int64_t> civil_to_ns(int year, int month, int day, int hour, int minute,
                                                      double second);

// ISO 8601 with milliseconds, "2016-06-23T16:31:59.000", no zone (the base is declared apart).
[[nodiscard]] std::string iso8601(std::int64_t time_ns);

}  // namespace cairn::base
