#include "base/time.hpp"

#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <utility>

namespace cairn::base {
namespace {

constexpr std::array<std::pair<TimeBase, std::string_view>, 4> kNames{{
    {TimeBase::utc, "utc"},
    {TimeBase::gps, "gps"},
    {TimeBase::boot, "boot"},
    {TimeBase::unknown, "unknown"},
}};

}  // namespace

std::string_view name_of(TimeBase base) {
  for (const auto& [value, name] : kNames)
    if (value == base) return name;
  return "unknown";
}

std::optional<TimeBase> time_base_from(std::string_view name) {
  for (const auto& [value, known] : kNames)
    if (known == name) return value;
  return std::nullopt;
}

std::optional<std::int64_t> civil_to_ns(int year, int month, int day, int hour, int minute, double second) {
  namespace chrono = std::chrono;
  const chrono::year_month_day date{chrono::year{year}, chrono::month{static_cast<unsigned>(month)},
                                    chrono::day{static_cast<unsigned>(day)}};
  // int64 nanoseconds reach from 1678 to 2262.
  if (!date.ok() || year < 1700 || year > 2250) return std::nullopt;
  if (hour < 0 || hour > 23 || minute < 0 || minute > 59) return std::nullopt;
  if (!(second >= 0.0) || second >= 61.0) return std::nullopt;
  const std::int64_t days = chrono::sys_days{date}.time_since_epoch().count();
  const std::int64_t whole = ((days * 24 + hour) * 60 + minute) * 60;
  return whole * 1'000'000'000 + static_cast<std::int64_t>(std::llround(second * 1e9));
}

std::string iso8601(std::int64_t time_ns) {
  namespace chrono = std::chrono;
  const chrono::sys_time<chrono::nanoseconds> instant{chrono::nanoseconds{time_ns}};
  const auto day = chrono::floor<chrono::days>(instant);
  const chrono::year_month_day date{day};
  const chrono::hh_mm_ss clock{chrono::floor<chrono::milliseconds>(instant - day)};
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), "%04d-%02u-%02uT%02d:%02d:%02d.%03d", static_cast<int>(date.year()),
                static_cast<unsigned>(date.month()), static_cast<unsigned>(date.day()),
                static_cast<int>(clock.hours().count()), static_cast<int>(clock.minutes().count()),
                static_cast<int>(clock.seconds().count()), static_cast<int>(clock.subseconds().count()));
  return text.data();
}

}  // namespace cairn::base
