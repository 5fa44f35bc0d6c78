#include "io/vehicle_log.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/number_text.hpp"
#include "io/bytes.hpp"
#include "io/tum_trajectory.hpp"
#include "io/vehicle_log_rows.hpp"

namespace cairn::io {
namespace {

using geometry::Vec2;

constexpr double kStanding_m_s = 0.05;  // slower, a difference of positions has no direction

// What the first line that is no comment looks like.
std::string format_of(const FileBytes& file) {
  TextReader reader(file.text(), file.name());
  while (const auto line = reader.next_line()) {
    std::string_view rest = base::trim(*line);
    if (rest.empty() || rest.front() == '#' || rest.front() == '%') continue;
    std::size_t words = 0;
    bool numbers = true;
    for (auto word = take_word(rest); !word.empty(); word = take_word(rest), ++words)
      numbers = numbers && parse_number(word).has_value();
    if (!numbers) return "csv";
    if (words == 8) return "tum";
    if (words == 3) return "plaza";
    if (words == 4)
      throw reader.error("rows of four numbers are ranges to beacons, or something else; not a motion log")
          .allowed("a table with a header row, rows of 8 numbers (TUM), rows of 3 numbers (Plaza)")
          .hint("Give the log with the vehicle's own motion, such as Plaza1_DR.txt");
    throw reader.error("not a motion log")
        .found(std::to_string(words) + " numbers in its first row")
        .allowed("a table with a header row, rows of 8 numbers (TUM), rows of 3 numbers (Plaza)");
  }
  throw reader.error("no row").allowed("a motion log");
}

std::vector<VehicleLogRow> tum_rows(const std::filesystem::path& path) {
  std::vector<VehicleLogRow> rows;
  for (const auto& pose : read_tum(path)) {
    VehicleLogRow row;
    row.record = "pose " + std::to_string(rows.size() + 1);
    row.state.time_ns = pose.time_ns;
    row.state.position = pose.T_world_body.translation.head<2>();
    const auto& r = pose.T_world_body.rotation;
    row.state.yaw = std::atan2(r(1, 0), r(0, 0));
    row.state.pitch = std::asin(std::clamp(-r(2, 0), -1.0, 1.0));
    row.state.roll = std::atan2(r(2, 1), r(2, 2));
    row.has_yaw = true;
    rows.push_back(row);
  }
  return rows;
}

std::vector<VehicleLogRow> plaza_rows(const FileBytes& file) {
  TextReader reader(file.text(), file.name());
  std::vector<VehicleLogRow> rows;
  Vec2 position = Vec2::Zero();
  double yaw = 0.0;
  while (const auto line = reader.next_line()) {
    std::string_view rest = base::trim(*line);
    if (rest.empty() || rest.front() == '#' || rest.front() == '%') continue;
    double value[3] = {};
    std::size_t count = 0;
    for (auto word = take_word(rest); !word.empty(); word = take_word(rest), ++count) {
      const auto number = parse_number(word);
      if (!number) throw reader.error("not a number").found("'" + std::string(word.substr(0, 60)) + "'");
      if (count < 3) value[count] = *number;
    }
    if (count != 3)
      throw reader.error("wrong number of columns")
          .found(std::to_string(count))
          .allowed("3: time [s], way [m], turn [rad]");
    VehicleLogRow row;
    row.record = "line " + std::to_string(reader.line());
    row.finite = std::isfinite(value[0]) && std::isfinite(value[1]) && std::isfinite(value[2]) &&
                 std::abs(value[0]) < kLatestSecond;
    if (row.finite) {
      row.state.time_ns = static_cast<std::int64_t>(std::llround(value[0] * 1e9));
      // The way is driven at the middle of the turn.
      position += value[1] * Vec2(std::cos(yaw + 0.5 * value[2]), std::sin(yaw + 0.5 * value[2]));
      yaw = std::remainder(yaw + value[2], 2.0 * std::numbers::pi);
    }
    row.state.position = position;
    row.state.yaw = yaw;
    row.has_yaw = true;
    rows.push_back(row);
  }
  return rows;
}

// What the log lacks, from its positions.
void derive(std::vector<VehicleLogRow>& rows) {
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (rows[i].has_velocity) continue;
    const auto& before = rows[i > 0 ? i - 1 : i].state;
    const auto& after = rows[std::min(i + 1, rows.size() - 1)].state;
    const double dt = static_cast<double>(after.time_ns - before.time_ns) * 1e-9;
    if (dt > 0.0) rows[i].state.velocity = (after.position - before.position) / dt;
  }
  double yaw = 0.0;
  bool known = false;
  const auto moving = [](const VehicleLogRow& row) { return row.state.velocity.norm() >= kStanding_m_s; };
  // Standing at the start, it will set off the way it first drives.
  for (const auto& row : rows)
    if (!known && (row.has_yaw || moving(row))) {
      yaw = row.has_yaw ? row.state.yaw : std::atan2(row.state.velocity.y(), row.state.velocity.x());
      known = true;
    }
  for (auto& row : rows) {
    if (!row.has_yaw && moving(row)) yaw = std::atan2(row.state.velocity.y(), row.state.velocity.x());
    if (row.has_yaw) yaw = row.state.yaw;
    row.state.yaw = yaw;
  }
}

}  // namespace

const std::vector<std::string>& vehicle_log_formats() {
  static const std::vector<std::string> kFormats{"auto", "csv", "tum", "plaza"};
  return kFormats;
}

VehicleLog read_vehicle_log(const std::filesystem::path& path, std::string_view format,
                            std::optional<geometry::Geodetic> origin) {
  const FileBytes file(path);
  VehicleLog log;
  log.format = format == "auto" ? format_of(file) : std::string(format);
  std::vector<VehicleLogRow> rows;
  if (log.format == "tum") {
    rows = tum_rows(path);
    log.convention = "TUM poses of a body whose x axis points forward, in a frame whose z axis points up";
  } else if (log.format == "plaza") {
    rows = plaza_rows(file);
    log.convention = "Ways and turns of wheel odometry, summed from the origin towards east";
  } else if (log.format == "csv") {
    rows = csv_vehicle_rows(file, origin, log.convention);
    log.origin = origin;
  } else {
    throw base::Error(base::ErrorCode::invalid_argument, "unknown format of a vehicle log")
        .found(std::string(format))
        .allowed("auto, csv, tum, plaza");
  }
  std::vector<VehicleLogRow> kept;
  kept.reserve(rows.size());
  for (auto& row : rows) {
    if (!row.finite) {
      log.rejects.push_back({row.record, "not_finite", row.record + ": a number is not finite"});
    } else if (!kept.empty() && row.state.time_ns <= kept.back().state.time_ns) {
      log.rejects.push_back({row.record, "time_not_ascending",
                             row.record + ": its time " + std::to_string(row.state.time_ns) +
                                 " ns is not later than the one before, " + std::to_string(kept.back().state.time_ns)});
    } else {
      kept.push_back(std::move(row));
    }
  }
  if (kept.empty())
    throw base::Error(base::ErrorCode::invalid_input, "no row of the log can be used")
        .file(path.string())
        .record("log")
        .found(std::to_string(log.rejects.size()) + " rows, all refused");
  derive(kept);
  log.samples.reserve(kept.size());
  for (const auto& row : kept) log.samples.push_back(row.state);
  return log;
}

}  // namespace cairn::io
