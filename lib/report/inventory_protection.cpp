#include <array>
#include <cctype>
#include <cmath>

#include "base/number_text.hpp"
#include "report/inventory.hpp"

namespace cairn::report {
namespace {

constexpr std::string_view kWithheld = "[withheld]";
constexpr int kPreciseDecimals = 3;     // 0.001 deg is 110 m
constexpr std::size_t kGridDigits = 6;  // of an easting or northing, or of a grid reference

bool is_digit(char c) {
  return c >= '0' && c <= '9';
}

int decimals_of(double step) {
  int decimals = 0;
  for (double s = step; s < 0.999 && decimals < 6; s *= 10.0) ++decimals;
  return decimals;
}

}  // namespace

std::string protected_text(std::string_view text, const Protection& protection) {
  if (!protection.on) return std::string(text);
  // Signs of degrees, minutes and seconds, as UTF-8.
  constexpr std::array<std::string_view, 6> kMarks{"°", "º", "′", "″", "'", "\""};
  std::string out;
  for (std::size_t i = 0; i < text.size();) {
    const auto rest = text.substr(i);
    if (rest.rfind("http://", 0) == 0 || rest.rfind("https://", 0) == 0 || rest.rfind("geo:", 0) == 0) {
      out += kWithheld;
      while (i < text.size() && std::isspace(static_cast<unsigned char>(text[i])) == 0) ++i;
      continue;
    }
    if (!is_digit(text[i])) {
      out += text[i++];
      continue;
    }
    std::size_t end = i;
    while (end < text.size() && is_digit(text[end])) ++end;
    const std::size_t whole = end - i;
    std::size_t decimals = 0;
    if (end + 1 < text.size() && (text[end] == '.' || text[end] == ',') && is_digit(text[end + 1])) {
      const std::size_t point = end++;
      while (end < text.size() && is_digit(text[end])) ++end;
      decimals = end - point - 1;
      // "1,2,3" is a list, not a number.
      if (text[point] == ',' && decimals < kPreciseDecimals) {
        end = point;
        decimals = 0;
      }
    }
    bool mark = false;
    for (const auto sign : kMarks) mark = mark || text.substr(end).rfind(sign, 0) == 0;
    std::string number(text.substr(i, end - i));
    if (const auto comma = number.find(','); comma != std::string::npos) number[comma] = '.';
    const auto value = base::parse_real(number);
    if (mark || whole >= kGridDigits) {
      out += kWithheld;
    } else if (decimals >= kPreciseDecimals && value && *value <= 180.0) {
      out += base::to_fixed(std::round(*value / protection.step_deg) * protection.step_deg,
                            decimals_of(protection.step_deg));
    } else {
      out += text.substr(i, end - i);
    }
    i = end;
  }
  return out;
}

std::string protection_text(const Protection& protection) {
  if (!protection.on) return "Coordinates are given as they were measured";
  return "PROTECTED: latitude and longitude are rounded to " + base::to_text(protection.step_deg) +
         " degrees and heights to " + base::to_text(protection.height_step_m) +
         " m; local coordinates, maps, support polygons on the map and photographs' names are left out";
}

}  // namespace cairn::report
