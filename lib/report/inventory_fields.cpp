#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>

#include "base/number_text.hpp"
#include "report/inventory.hpp"

namespace cairn::report {
namespace {

using io::ColumnType;

InventoryField text(const char* name, const char* definition) {
  return {name, ColumnType::text, "", definition};
}
InventoryField real(const char* name, const char* unit, const char* definition) {
  return {name, ColumnType::real, unit, definition};
}

constexpr std::array<std::pair<std::string_view, std::string_view>, 10> kOtherNames{{{"status", "field_status"},
                                                                                     {"unit", "rock_unit"},
                                                                                     {"rock_name", "name"},
                                                                                     {"access", "access_note"},
                                                                                     {"observer", "observers"},
                                                                                     {"density", "density_kg_m3"},
                                                                                     {"vs30", "vs30_m_s"},
                                                                                     {"age_ka", "age_best_ka"},
                                                                                     {"note", "field_note"},
                                                                                     {"notes", "field_note"}}};

}  // namespace

const std::vector<InventoryField>& inventory_fields() {
  static const std::vector<InventoryField> fields{
      text("name", "the rock's name in the field, else class and number"),
      text("site", "site"),
      text("region", "region"),
      text("access_note", "how to get there; withheld in a protected inventory"),
      text("discoverer", "who found it"),
      text("observers", "who observed it"),
      text("field_status", "in the field: standing, toppled, removed, altered"),
      text("lithology", "lithology"),
      text("rock_unit", "geological unit"),
      text("weathering", "weathering"),
      text("joints", "joints"),
      real("density_kg_m3", "kg/m3", "density used"),
      real("density_sigma_kg_m3", "kg/m3", "1 sigma of the density"),
      real("age_best_ka", "ka", "age of the rock in its present position, thousand years: best estimate"),
      real("age_min_ka", "ka", "least age"),
      real("age_max_ka", "ka", "greatest age"),
      text("age_method", "how the age was found"),
      text("age_samples", "samples of the age"),
      text("exhumation_model", "exhumation model of the age"),
      text("lateral_support", "support above the contact that hinders toppling"),
      real("site_slope_deg", "deg", "slope of the ground around"),
      real("distance_to_cliff_m", "m", "distance to the nearest cliff"),
      text("topographic_note", "topography around: ridge, slope, valley"),
      real("vs30_m_s", "m/s", "mean shear-wave velocity of the upper 30 m"),
      real("rocking_frequency_hz", "Hz", "measured rocking frequency"),
      text("push_test", "result of a push test"),
      text("site_class", "class given in the field"),
      text("scale_bar", "scale bar in the photographs"),
      text("field_note", "remark from the field")};
  return fields;
}

std::optional<std::string> inventory_field(std::string_view name) {
  for (const auto& [other, own] : kOtherNames)
    if (other == name) return std::string(own);
  for (const auto& field : inventory_fields())
    if (field.name == name) return field.name;
  return std::nullopt;
}

std::string field_problem(std::string_view field, std::string_view value) {
  for (const auto& known : inventory_fields()) {
    if (known.name != field) continue;
    if (known.type != ColumnType::real) return "";
    const auto number = base::parse_real(value);
    if (!number || !std::isfinite(*number)) return "a number" + (known.unit.empty() ? "" : " [" + known.unit + "]");
    if (known.name == "density_kg_m3" && !(*number >= 500.0 && *number <= 8000.0)) return "500 to 8000 kg/m3";
    if (*number < 0.0) return "0 or more";
    return "";
  }
  return "";
}

std::string slug_of(std::string_view name) {
  std::string slug;
  for (const char c : name) {
    const auto u = static_cast<unsigned char>(c);
    if (u < 128 && std::isalnum(u) != 0) slug += static_cast<char>(std::tolower(u));
    else if (!slug.empty() && slug.back() != '-') slug += '-';
  }
  while (!slug.empty() && slug.back() == '-') slug.pop_back();
  return slug.empty() ? "survey" : slug;
}

std::string inventory_id(std::string_view slug, survey::TargetId rock) {
  constexpr std::size_t kDigits = 4;
  const std::string number = std::to_string(rock.value);
  return std::string(slug) + "-" + std::string(number.size() < kDigits ? kDigits - number.size() : 0, '0') + number;
}

std::optional<geometry::Vec3> place_of(const survey::Rock& rock, const std::optional<survey::Target>& target) {
  if (rock.mass) return rock.mass->centre_of_mass;
  if (target) return target->centre;
  return std::nullopt;
}

}  // namespace cairn::report
