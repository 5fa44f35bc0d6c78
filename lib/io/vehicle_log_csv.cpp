#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>
#include <numbers>

#include "base/angle.hpp"
#include "base/number_text.hpp"
#include "geodesy/local_frame.hpp"
#include "io/csv.hpp"
#include "io/vehicle_log_rows.hpp"

namespace cairn::io {
namespace {

// "Time [s]", "Vx (m/s)" and "pose.position.x" as time_s, vx_m_s and pose_position_x.
std::string plain_name(std::string_view text) {
  std::string out;
  for (const char c : base::trim(text)) {
    if (c >= 'A' && c <= 'Z') out += static_cast<char>(c - 'A' + 'a');
    else if ((c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '%') out += c;
    else if (!out.empty() && out.back() != '_') out += '_';
  }
  while (!out.empty() && out.back() == '_') out.pop_back();
  return out;
}

struct Column {
  std::size_t index = 0;
  double scale = 1.0;  // to the unit that is wanted
  std::string name;
};

struct Alias {
  const char* name;
  double scale;
};

class Table {
 public:
  explicit Table(CsvReader& csv) : csv_(csv) {
    for (const auto& name : csv.header()) names_.push_back(plain_name(name));
  }
  [[nodiscard]] std::optional<Column> find(std::initializer_list<Alias> aliases) const {
    for (const auto& alias : aliases)
      for (std::size_t i = 0; i < names_.size(); ++i)
        if (names_[i] == alias.name) return Column{i, alias.scale, names_[i]};
    return std::nullopt;
  }
  // NaN where the cell says so; a word throws.
  [[nodiscard]] double value(const Column& column) const {
    const auto text = csv_.required(column.index);
    const auto number = base::parse_real(text);
    if (!number) throw csv_.error(column.index, "not a number").found(std::string(text.substr(0, 60)));
    return column.scale * *number;
  }

 private:
  CsvReader& csv_;
  std::vector<std::string> names_;
};

// Seconds as text to nanoseconds without the rounding of a double.
std::int64_t nanoseconds(std::string_view text, double value_s) {
  const auto trimmed = base::trim(text);
  const auto point = trimmed.find('.');
  const auto whole = base::parse_integer(trimmed.substr(0, point));
  if (!whole || trimmed.find_first_not_of("0123456789.") != std::string_view::npos)
    return static_cast<std::int64_t>(std::llround(value_s * 1e9));
  std::int64_t fraction = 0, unit = 100'000'000;
  if (point != std::string_view::npos)
    for (const char c : trimmed.substr(point + 1)) {
      fraction += unit * (c - '0');
      unit /= 10;
    }
  return *whole * 1'000'000'000 + fraction;
}

char separator_of(std::string_view text) {
  TextReader reader(text, "");
  while (const auto line = reader.next_line()) {
    if (line->empty() || line->front() == '#') continue;
    if (line->find(',') != std::string_view::npos) return ',';
    return line->find(';') != std::string_view::npos ? ';' : '\t';
  }
  return ',';
}

constexpr double kDegree = std::numbers::pi / 180.0;

struct Columns {
  std::optional<Column> time, x, y, latitude, longitude, vx, vy, roll, pitch, heading, yaw, xx, xy, yy;
};

Columns columns_of(const Table& t) {
  Columns c;
  c.time = t.find({{"time_ns", 1e-9},
                   {"timestamp_ns", 1e-9},
                   {"stamp_ns", 1e-9},
                   {"%time", 1e-9},
                   {"capture_time_ns", 1e-9},
                   {"time_us", 1e-6},
                   {"timestamp_us", 1e-6},
                   {"time_ms", 1e-3},
                   {"timestamp_ms", 1e-3},
                   {"time_s", 1.0},
                   {"timestamp_s", 1.0},
                   {"time", 1.0},
                   {"timestamp", 1.0},
                   {"t", 1.0},
                   {"stamp", 1.0},
                   {"sec", 1.0},
                   {"seconds", 1.0}});
  c.x = t.find({{"x_m", 1.0},
                {"x", 1.0},
                {"east_m", 1.0},
                {"east", 1.0},
                {"e", 1.0},
                {"px", 1.0},
                {"position_x", 1.0},
                {"pos_x", 1.0},
                {"pose_position_x", 1.0},
                {"pose_pose_position_x", 1.0},
                {"field_pose_pose_position_x", 1.0},
                {"field_pose_position_x", 1.0}});
  c.y = t.find({{"y_m", 1.0},
                {"y", 1.0},
                {"north_m", 1.0},
                {"north", 1.0},
                {"n", 1.0},
                {"py", 1.0},
                {"position_y", 1.0},
                {"pos_y", 1.0},
                {"pose_position_y", 1.0},
                {"pose_pose_position_y", 1.0},
                {"field_pose_pose_position_y", 1.0},
                {"field_pose_position_y", 1.0}});
  c.latitude = t.find({{"latitude_deg", 1.0}, {"lat_deg", 1.0}, {"latitude", 1.0}, {"lat", 1.0}});
  c.longitude = t.find({{"longitude_deg", 1.0}, {"lon_deg", 1.0}, {"longitude", 1.0}, {"lon", 1.0}, {"lng", 1.0}});
  c.vx = t.find({{"vx_m_s", 1.0}, {"vx", 1.0}, {"v_east", 1.0}, {"ve", 1.0}, {"velocity_x", 1.0}, {"vel_x", 1.0}});
  c.vy = t.find({{"vy_m_s", 1.0}, {"vy", 1.0}, {"v_north", 1.0}, {"vn", 1.0}, {"velocity_y", 1.0}, {"vel_y", 1.0}});
  c.roll = t.find({{"roll_deg", kDegree}, {"roll", kDegree}, {"roll_rad", 1.0}});
  c.pitch = t.find({{"pitch_deg", kDegree}, {"pitch", kDegree}, {"pitch_rad", 1.0}});
  c.heading = t.find({{"heading_deg", kDegree}, {"heading", kDegree}, {"heading_rad", 1.0}});
  c.yaw = t.find({{"yaw_deg", kDegree}, {"yaw_rad", 1.0}, {"yaw", 1.0}, {"theta", 1.0}});
  c.xx = t.find({{"var_xx_m2", 1.0}});
  c.xy = t.find({{"var_xy_m2", 1.0}});
  c.yy = t.find({{"var_yy_m2", 1.0}});
  return c;
}

}  // namespace

std::vector<VehicleLogRow> csv_vehicle_rows(const FileBytes& file, std::optional<geometry::Geodetic>& origin,
                                            std::string& convention) {
  CsvReader csv(file.text(), file.name(), separator_of(file.text()));
  const Table table(csv);
  const Columns c = columns_of(table);
  const bool metres = c.x && c.y, degrees = c.latitude && c.longitude;
  if (!c.time || (!metres && !degrees))
    throw bad_line(file.name(), 1, c.time ? "the log has no positions" : "the log has no times")
        .allowed(c.time ? "columns x_m, y_m or latitude_deg, longitude_deg" : "a column time_ns or time_s");
  convention =
      "Times from " + c.time->name + ", positions from " +
      (metres ? c.x->name + " (east) and " + c.y->name + " (north)" : c.latitude->name + " and " + c.longitude->name) +
      ", velocities from " + (c.vx && c.vy ? c.vx->name + " and " + c.vy->name : "the positions") + ", headings from " +
      (c.heading ? c.heading->name + " (clockwise from north)"
       : c.yaw   ? c.yaw->name + " (counter-clockwise from east)"
                 : "the velocities");
  if (metres) origin.reset();
  std::optional<geodesy::LocalFrame> frame;
  if (degrees && !metres && origin) frame.emplace(*origin);
  std::vector<VehicleLogRow> rows;
  while (csv.next()) {
    VehicleLogRow row;
    row.record = "line " + std::to_string(csv.line());
    const auto get = [&](const std::optional<Column>& column) {
      const double v = column ? table.value(*column) : 0.0;
      row.finite = row.finite && std::isfinite(v);
      return v;
    };
    auto& s = row.state;
    const double time_s = get(c.time);
    row.finite = row.finite && std::abs(time_s) < kLatestSecond;
    if (metres) {
      s.position = {get(c.x), get(c.y)};
    } else {
      const geometry::Geodetic p{get(c.latitude), get(c.longitude), origin ? origin->height_m : 0.0};
      if (row.finite) {
        if (!frame) {
          origin = p;
          frame.emplace(p);
        }
        s.position = frame->to_local(p).head<2>();
      }
    }
    row.has_velocity = c.vx && c.vy;
    if (row.has_velocity) s.velocity = {get(c.vx), get(c.vy)};
    s.roll = get(c.roll);
    s.pitch = get(c.pitch);
    row.has_yaw = c.heading || c.yaw;
    if (c.heading) s.yaw = std::remainder(0.5 * std::numbers::pi - get(c.heading), 2.0 * std::numbers::pi);
    else if (c.yaw) s.yaw = std::remainder(get(c.yaw), 2.0 * std::numbers::pi);
    if (c.xx && c.xy && c.yy && !csv.text(c.xx->index).empty()) {
      geometry::Mat2 m;
      m << get(c.xx), get(c.xy), get(c.xy), get(c.yy);
      if (row.finite && (m(0, 0) < 0.0 || m(1, 1) < 0.0 || m(0, 1) * m(0, 1) > m(0, 0) * m(1, 1) * (1.0 + 1e-9)))
        throw csv.error(c.xx->index, "the covariance is not positive semi-definite");
      s.covariance = m;
    }
    if (row.finite)
      s.time_ns = c.time->scale == 1e-9  ? csv.integer(c.time->index)
                  : c.time->scale == 1.0 ? nanoseconds(csv.text(c.time->index), time_s)
                                         : static_cast<std::int64_t>(std::llround(time_s * 1e9));
    rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace cairn::io
