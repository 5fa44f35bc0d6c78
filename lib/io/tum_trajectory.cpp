#include "io/tum_trajectory.hpp"

#include <array>
#include <cmath>
#include <string>

#include "base/number_text.hpp"
#include "io/bytes.hpp"

namespace cairn::io {
namespace {

constexpr double kNormTolerance = 1e-2;  // of a quaternion: four printed decimals
constexpr double kLatest = 9.2e9;        // s: what int64 nanoseconds hold

// Seconds with a decimal fraction to nanoseconds, without the rounding of a double (1e9 s has steps of 0.1 us).
std::optional<std::int64_t> nanoseconds(std::string_view word) {
  const auto value = parse_number(word);
  if (!value || !(std::abs(*value) < kLatest)) return std::nullopt;
  const auto point = word.find('.');
  const auto whole = base::parse_integer(word.substr(0, point));
  const bool plain = word.find_first_not_of("0123456789.") == std::string_view::npos;
  if (!plain || !whole) return static_cast<std::int64_t>(std::llround(*value * 1e9));
  std::int64_t fraction = 0, unit = 100'000'000;
  if (point != std::string_view::npos)
    for (const char c : word.substr(point + 1)) {
      fraction += unit * (c - '0');
      unit /= 10;
    }
  return *whole * 1'000'000'000 + fraction;
}

}  // namespace

std::vector<TumPose> read_tum(const std::filesystem::path& path) {
  const FileBytes bytes(path);
  TextReader reader(bytes.text(), bytes.name());
  std::vector<TumPose> poses;
  while (auto line = reader.next_line()) {
    std::string_view rest = base::trim(*line);
    if (rest.empty() || rest.front() == '#') continue;
    std::array<double, 8> v{};
    std::size_t count = 0;
    std::string_view stamp;
    for (auto word = take_word(rest); !word.empty(); word = take_word(rest), ++count) {
      if (count == 0) stamp = word;
      const auto value = parse_number(word);
      if (!value || !std::isfinite(*value))
        throw reader.error("not a finite number").found("'" + std::string(word.substr(0, 60)) + "'");
      if (count < v.size()) v[count] = *value;
    }
    if (count != v.size())
      throw reader.error("wrong number of columns")
          .found(std::to_string(count))
          .allowed("8: timestamp tx ty tz qx qy qz qw");
    const auto time = nanoseconds(stamp);
    if (!time) throw reader.error("time stamp out of range").found(std::string(stamp)).allowed("seconds");
    const geometry::Quaternion q{v[7], v[4], v[5], v[6]};
    if (std::abs(q.norm() - 1.0) > kNormTolerance)
      throw reader.error("quaternion is not a rotation")
          .found("norm " + base::to_text(q.norm()))
          .allowed("1 within 1 %; the order is qx qy qz qw");
    poses.push_back({*time, {geometry::rotation_matrix(q), {v[1], v[2], v[3]}}});
  }
  if (poses.empty()) throw reader.error("no pose").allowed("rows of timestamp tx ty tz qx qy qz qw");
  return poses;
}

}  // namespace cairn::io
