#include "report/inventory.hpp"

#include <cmath>

#include "base/error.hpp"
#include "report/inventory_rows.hpp"
#include "report/layer_looks.hpp"

namespace cairn::report {

double rounded_to(double value, double step) {
  if (!(step > 0.0)) return value;
  // Divided by a whole number where there is one, so that 46.84 is written as such.
  const double parts = std::round(1.0 / step);
  constexpr double kWhole = 1e-9;
  if (step < 1.0 && std::abs(parts * step - 1.0) < kWhole) return std::round(value * parts) / parts + 0.0;
  return std::round(value / step) * step + 0.0;
}

std::string joined_text(const std::vector<std::string>& items, std::string_view separator) {
  std::string text;
  for (const auto& item : items) {
    if (!text.empty()) text += separator;
    text += item;
  }
  return text;
}

InventoryRow::InventoryRow(const Inventory& all, const InventoryRock& one, const geodesy::LocalFrame* local)
    : inventory(all), entry(one), rock(one.rock), survey(all.surveys.at(one.survey)) {
  const Protection& protection = inventory.protection;
  const auto centre = place_of(rock, one.target);
  if (centre && local != nullptr) {
    geometry::Geodetic g = local->to_geodetic(*centre);
    const geometry::Geodetic foot = local->to_geodetic({centre->x(), centre->y(), rock.base_height_m});
    if (rock.mass) base_height_m = foot.height_m;
    if (protection.on) {
      // A latitude of exactly 90 degrees would round to one, too.
      g.latitude_deg = rounded_to(g.latitude_deg, protection.step_deg);
      g.longitude_deg = rounded_to(g.longitude_deg, protection.step_deg);
      g.height_m = rounded_to(g.height_m, protection.height_step_m);
      if (base_height_m) base_height_m = rounded_to(*base_height_m, protection.height_step_m);
    }
    position = g;
  }
  if (!protection.on) place = centre;
  for (const auto& [name, value] : one.field) field.emplace(name, value);  // the first of a name counts
  const auto noted = field.find("density_kg_m3");
  density_kg_m3 = rock.density_kg_m3;
  if (rock.mass) density_source = rock.density_assumed ? "assumed" : "given";
  if (noted != field.end()) {
    density_kg_m3 = std::stod(noted->second);
    density_source = "field";
  }
  measured = !rock.rejected && rock.tipping.grade != survey::Grade::not_measurable && rock.tipping.critical.has_value();
}

std::string InventoryRow::text_of(std::string_view field_name) const {
  const auto it = field.find(field_name);
  if (it == field.end()) return "";
  if (inventory.protection.on && field_name == "access_note") return "[withheld]";
  return protected_text(it->second, inventory.protection);
}

double InventoryRow::density_ratio() const {
  return rock.density_kg_m3 > 0.0 ? density_kg_m3 / rock.density_kg_m3 : 1.0;
}

std::vector<io::Layer> inventory_layers(const Inventory& inventory) {
  std::vector<std::optional<geodesy::LocalFrame>> frames;
  for (const auto& survey : inventory.surveys)
    frames.push_back(survey.origin ? std::optional(geodesy::LocalFrame(survey.origin->position)) : std::nullopt);
  std::vector<std::unique_ptr<InventoryRow>> rows;
  for (const auto& rock : inventory.rocks) {
    const auto& frame = frames.at(rock.survey);
    rows.push_back(std::make_unique<InventoryRow>(inventory, rock, frame ? &*frame : nullptr));
  }

  io::Layer layer;
  layer.name = "inventory";
  layer.title = "Rocks of all surveys, at the centre of mass. " + protection_text(inventory.protection);
  layer.kind = io::GeometryKind::point;
  layer.with_heights = true;
  // One datum only can be the layer's; each rock names its own.
  bool first = true, same = true;
  for (const auto& survey : inventory.surveys) {
    if (!survey.origin) continue;
    if (first) {
      layer.height_type = survey.origin->height_type;
      layer.geoid = survey.origin->geoid;
      first = false;
    }
    same = same && survey.origin->height_type == layer.height_type && survey.origin->geoid == layer.geoid;
  }
  if (!same) {
    layer.height_type = survey::HeightType::unknown;
    layer.geoid.clear();
  }
  const auto columns = inventory_columns(inventory);
  for (const auto& c : columns) layer.columns.push_back(c.column);
  for (const auto& row : rows) {
    io::Feature feature;
    if (row->position) feature.parts = {{{*row->position}}};
    for (const auto& c : columns) feature.values.push_back(c.value(*row));
    layer.features.push_back(std::move(feature));
  }
  layer.style = look_of(layer);
  std::vector<io::Layer> layers;
  layers.push_back(std::move(layer));
  for (auto& table : inventory_tables(inventory, rows, frames)) layers.push_back(std::move(table));
  return layers;
}

}  // namespace cairn::report
