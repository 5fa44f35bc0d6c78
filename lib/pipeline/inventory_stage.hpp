// Stage `inventory`: the results of one or many surveys -> one inventory of rocks.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/options.hpp"
#include "base/run_context.hpp"
#include "pipeline/outcome.hpp"
#include "pipeline/stage.hpp"

namespace cairn::pipeline {

struct InventoryOptions {
  std::string notes;                     // table of field notes; "" = none
  double notes_within_m = 5.0;           // a note without an id goes to the nearest rock within this, in plan
  std::string previous;                  // inventory.csv made before, whose ids are kept; "" = none
  double same_within_m = 1.0;            // rocks of two surveys nearer than this are one
  bool protect = false;                  // for publication: round coordinates everywhere
  double protect_step_deg = 0.01;        // of latitude and longitude
  double protect_height_step_m = 100.0;  // of heights
  bool kml = true;                       // inventory.kml; needs the EGM96 grid where heights are ellipsoidal
  bool pictures = true;                  // the contact sheet's pictures of the meshes

  void visit(base::OptionVisitor& v) {
    v.text("notes", notes, "CSV of field notes, joined by id or by nearest position");
    v.real("notes-within-m", notes_within_m, 0.01, 1000.0,
           "a note without an id goes to the nearest rock within this, m");
    v.text("previous", previous, "inventory.csv made before: rocks at the same places keep their ids");
    v.real("same-within-m", same_within_m, 0.01, 100.0, "rocks of two surveys nearer than this are the same, m");
    v.flag("protect", protect, "round coordinates everywhere, for publication");
    v.real("protect-step-deg", protect_step_deg, 0.001, 1.0,
           "protected latitudes and longitudes are multiples of this");
    v.real("protect-height-step-m", protect_height_step_m, 1.0, 1000.0, "protected heights are multiples of this, m");
    v.flag("kml", kml, "write inventory.kml");
    v.flag("pictures", pictures, "draw each rock on the contact sheet");
  }
};

struct InventorySource {
  std::filesystem::path result;  // folder of cairn run, review or fragility
  std::filesystem::path survey;  // survey folder; "" = not known: no photographs
  std::string name;              // of the survey
  // What made it, where its run.json does not say so yet.
  std::string version = {};
  std::optional<std::int64_t> seed = {};
};

// Name and survey of a result: from the survey that its run.json names where that can still be read, else the folder's
// name. Throws invalid_input where the folder holds no rocks.json.
[[nodiscard]] InventorySource inventory_source(const std::filesystem::path& result);

// Writes inventory.gpkg, inventory.csv, inventory.geojson, inventory.kml, columns.csv (definition and unit of every
// column), rejects.csv, rocks/<id>.json, and of the site: index.html, contact_sheet.svg, grades.svg, map.svg (not where
// protected). Throws invalid_input where two surveys have one name, a note names a rock that is not there or holds a
// value that does not fit its field. Notes that no rock is near to are rejects.
[[nodiscard]] Outcome inventory_files(const std::vector<InventorySource>& sources, const std::filesystem::path& out,
                                      const InventoryOptions& options, base::RunContext& ctx);

// The recipe's stage: rocks.json, targets.json, rocks/ -> inventory/.
[[nodiscard]] std::unique_ptr<Stage> make_inventory_stage();

}  // namespace cairn::pipeline
