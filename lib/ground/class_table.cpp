#include "ground/class_table.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <functional>

#include "base/error.hpp"
#include "base/number_text.hpp"

namespace cairn::ground {
namespace {

bool same_name(std::string_view a, std::string_view b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](char x, char y) {
    return std::tolower(static_cast<unsigned char>(x)) == std::tolower(static_cast<unsigned char>(y));
  });
}

// Calls `use` with each trimmed entry until it returns true; whether it did.
bool any_entry(std::string_view table, char separator, const std::function<bool(std::string_view)>& use) {
  for (std::size_t begin = 0; begin <= table.size();) {
    const std::size_t end = std::min(table.find(separator, begin), table.size());
    if (use(base::trim(table.substr(begin, end - begin)))) return true;
    begin = end + 1;
  }
  return false;
}

bool listed(std::string_view name, std::string_view table) {
  return any_entry(table, ',', [name](std::string_view entry) { return same_name(entry, name); });
}

[[noreturn]] void unreadable(std::string_view entry) {
  throw base::Error(base::ErrorCode::invalid_argument, "an entry of --class-shapes cannot be read")
      .found("'" + std::string(entry) + "'")
      .allowed("class:cylinder|cone|ball:HEIGHT(m|x):SIGMA, height and sigma positive");
}

ObjectModel model_of_entry(std::string_view entry, const std::array<std::string_view, 4>& fields) {
  ObjectModel model;
  if (same_name(fields[1], "cylinder")) model.shape = Shape::cylinder;
  else if (same_name(fields[1], "cone")) model.shape = Shape::cone;
  else if (same_name(fields[1], "ball")) model.shape = Shape::ball;
  else unreadable(entry);
  if (fields[2].size() < 2 || (fields[2].back() != 'm' && fields[2].back() != 'x')) unreadable(entry);
  model.height_by_width = fields[2].back() == 'x';
  const auto height = base::parse_real(fields[2].substr(0, fields[2].size() - 1));
  const auto sigma = base::parse_real(fields[3]);
  if (!height || !sigma || !(*height > 0.0) || !(*sigma > 0.0) || !std::isfinite(*height + *sigma)) unreadable(entry);
  model.height = *height;
  model.sigma_log_height = *sigma;
  return model;
}

}  // namespace

void ClassTable::visit(base::OptionVisitor& v) {
  v.text("obstacle-classes", obstacle_classes, "classes a vehicle must avoid, comma-separated");
  v.text("ignored-classes", ignored_classes, "classes a vehicle passes below");
  v.text("vehicle-classes", vehicle_classes, "classes that are the vehicle itself");
  v.text("class-shapes", class_shapes, "class:shape:height:sigma of objects seen once, comma-separated");
}

std::optional<survey::ObstacleKind> kind_of_class(std::string_view object_class, const ClassTable& table) {
  using survey::ObstacleKind;
  if (listed(object_class, table.vehicle_classes)) return ObstacleKind::vehicle;
  if (listed(object_class, table.ignored_classes)) return ObstacleKind::ignored;
  if (listed(object_class, table.obstacle_classes)) return ObstacleKind::obstacle;
  return std::nullopt;
}

ObjectModel model_of_class(std::string_view object_class, const ClassTable& table) {
  ObjectModel model;
  any_entry(table.class_shapes, ',', [&](std::string_view entry) {
    if (entry.empty()) return false;
    std::array<std::string_view, 4> fields;
    std::size_t count = 0;
    any_entry(entry, ':', [&](std::string_view field) {
      if (count < fields.size()) fields.at(count) = field;
      ++count;
      return false;
    });
    if (count != fields.size()) unreadable(entry);
    const bool named = same_name(fields[0], object_class);
    const ObjectModel here = model_of_entry(entry, fields);
    if (named || fields[0] == "*") model = here;
    return named;
  });
  model.vehicle = kind_of_class(object_class, table) == survey::ObstacleKind::vehicle;
  return model;
}

}  // namespace cairn::ground
