// What the rows of the inventory's tables are made from. Internal to the inventory.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "geodesy/local_frame.hpp"
#include "report/inventory.hpp"

namespace cairn::report {

// One rock with everything looked up; positions are protected already.
struct InventoryRow {
  InventoryRow(const Inventory& all, const InventoryRock& one, const geodesy::LocalFrame* local);

  const Inventory& inventory;
  const InventoryRock& entry;
  const survey::Rock& rock;
  const InventorySurvey& survey;
  std::optional<geometry::Vec3> place;         // local; empty where protected
  std::optional<geometry::Geodetic> position;  // of the point; protected
  std::optional<double> base_height_m;         // in the survey's datum; protected
  std::map<std::string, std::string, std::less<>> field;
  double density_kg_m3 = 0.0;
  std::string density_source;  // assumed, given, field, or ""
  bool measured = false;       // figures of tipping may be given

  [[nodiscard]] std::string text_of(std::string_view field_name) const;  // protected
  // Of the result's density to the one used: what is proportional to the mass is scaled by it.
  [[nodiscard]] double density_ratio() const;
};

// A column with the way to its value.
struct InventoryColumn {
  io::Column column;
  std::function<io::Value(const InventoryRow&)> value;
};
[[nodiscard]] std::vector<InventoryColumn> inventory_columns(const Inventory& inventory);

// The other tables, after `inventory`.
[[nodiscard]] std::vector<io::Layer> inventory_tables(const Inventory& inventory,
                                                      const std::vector<std::unique_ptr<InventoryRow>>& rows,
                                                      const std::vector<std::optional<geodesy::LocalFrame>>& frames);

[[nodiscard]] double rounded_to(double value, double step);
[[nodiscard]] std::string joined_text(const std::vector<std::string>& items, std::string_view separator = ";");

}  // namespace cairn::report
