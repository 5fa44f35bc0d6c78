#include "pipeline/inventory_stage.hpp"

#include <map>
#include <set>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "base/version.hpp"
#include "io/geojson.hpp"
#include "io/kml.hpp"
#include "io/layer_csv.hpp"
#include "io/survey_folder.hpp"
#include "io/vector.hpp"
#include "pipeline/function_stage.hpp"
#include "pipeline/inventory_join.hpp"
#include "pipeline/inventory_read.hpp"
#include "pipeline/inventory_site.hpp"
#include "report/inventory.hpp"

namespace cairn::pipeline {
namespace fs = std::filesystem;
namespace {

using base::Error;
using base::ErrorCode;

void require_unique_names(const std::vector<InventorySource>& sources, const report::Protection& protection) {
  std::map<std::string, std::string> seen;
  for (const auto& source : sources) {
    const std::string slug = report::slug_of(report::protected_text(source.name, protection));
    const auto [it, fresh] = seen.emplace(slug, source.result.string());
    if (!fresh)
      throw Error(ErrorCode::invalid_input, "two results have one survey's name, so that their rocks would share ids")
          .file(source.result.string())
          .found("'" + source.name + "', as " + it->second)
          .hint("Tell them apart with --names: one name a result, in order");
  }
}

io::Layer columns_table(const std::vector<io::Layer>& layers) {
  io::Layer table;
  table.name = "columns";
  table.kind = io::GeometryKind::none;
  table.with_heights = false;
  for (const char* name : {"table", "column", "type", "unit", "definition"})
    table.columns.push_back({name, io::ColumnType::text, "", ""});
  for (const auto& layer : layers)
    for (const auto& column : layer.columns) {
      io::Feature feature;
      feature.values = {layer.name, column.name, std::string(io::name_of(column.type)), column.unit, column.definition};
      table.features.push_back(std::move(feature));
    }
  return table;
}

const io::Layer& layer_named(const std::vector<io::Layer>& layers, std::string_view name) {
  for (const auto& layer : layers)
    if (layer.name == name) return layer;
  throw Error(ErrorCode::internal, "no such table").found(name);
}

void write_tables(const std::vector<io::Layer>& layers, const fs::path& out, const InventoryOptions& options,
                  base::RunContext& ctx) {
  const io::Layer& main = layers.front();
  io::write_geopackage(out / "inventory.gpkg", layers);
  io::write_layer_csv(out / "inventory.csv", main);
  io::write_geojson(out / "inventory.geojson", main);
  if (options.kml) {
    bool placed = false;
    for (const auto& feature : main.features) placed = placed || !feature.parts.empty();
    if (placed) io::write_kml(out / "inventory.kml", {main}, "cairn inventory");
    else ctx.warn("No rock has a position on Earth: inventory.kml is not written");
  }
  io::write_layer_csv(out / "columns.csv", columns_table(layers));
  io::write_layer_csv(out / "rejects.csv", layer_named(layers, "rejects"));
  fs::create_directories(out / "rocks");
  for (std::size_t i = 0; i < main.features.size(); ++i) {
    ctx.check_stop();
    const auto& id = std::get<std::string>(main.features[i].values.at(0));
    base::write_file(out / "rocks" / (id + ".json"), report::rock_json(layers, i).dump() + "\n");
  }
}

io::Json count_of_grades(const report::Inventory& inventory) {
  std::map<std::string, std::int64_t> counts;
  for (const auto& rock : inventory.rocks)
    if (!rock.rock.rejected) ++counts[std::string(survey::name_of(rock.rock.tipping.grade))];
  io::Json json = io::Json::object();
  for (const auto& [name, count] : counts) json.set(name, count);
  return json;
}

}  // namespace

Outcome inventory_files(const std::vector<InventorySource>& sources, const fs::path& out,
                        const InventoryOptions& options, base::RunContext& ctx) {
  InventoryOptions checked = options;
  base::validate(base::bind_options(checked), "inventory");
  report::Inventory inventory;
  inventory.protection = {options.protect, options.protect_step_deg, options.protect_height_step_m};
  require_unique_names(sources, inventory.protection);
  std::vector<fs::path> meshes;
  for (const auto& source : sources) add_result(inventory, meshes, source, ctx);

  Outcome outcome;
  std::size_t kept = 0;
  if (!options.previous.empty()) kept = keep_previous_ids(inventory, options);
  const std::size_t revisits = find_revisits(inventory, options.same_within_m);
  if (!options.notes.empty()) outcome.rejects = join_notes(inventory, options);
  std::set<std::string> ids;
  for (auto& rock : inventory.rocks) {
    // Ids of an earlier inventory may be made of a name with coordinates.
    rock.id = report::protected_text(rock.id, inventory.protection);
    rock.revisit_of = report::protected_text(rock.revisit_of, inventory.protection);
    for (auto* list : {&rock.aliases, &rock.supersedes})
      for (auto& id : *list) id = report::protected_text(id, inventory.protection);
  }
  for (const auto& rock : inventory.rocks)
    if (!ids.insert(rock.id).second) throw Error(ErrorCode::internal, "two rocks have one id").found(rock.id);

  const auto layers = report::inventory_layers(inventory);
  write_tables(layers, out, options, ctx);
  write_site(inventory, meshes, out, options, ctx);

  std::size_t rejected = 0, noted = 0;
  for (const auto& rock : inventory.rocks) {
    rejected += rock.rock.rejected ? 1U : 0U;
    noted += rock.notes > 0 ? 1U : 0U;
  }
  io::Json reasons = io::Json::object();
  for (const auto& row : layer_named(layers, "rejects").features)
    if (std::get<std::string>(row.values[0]) == "rejected")
      reasons.set(std::get<std::string>(row.values[1]), std::get<std::int64_t>(row.values[2]));
  outcome.summary = io::Json::object({{"surveys", inventory.surveys.size()},
                                      {"rocks", inventory.rocks.size()},
                                      {"rejected", rejected},
                                      {"rejected_by_reason", std::move(reasons)},
                                      {"by_grade", count_of_grades(inventory)},
                                      {"with_field_notes", noted},
                                      {"notes_not_joined", outcome.rejects.size()},
                                      {"ids_kept", kept},
                                      {"revisits", revisits},
                                      {"protected", options.protect},
                                      {"coordinates", report::protection_text(inventory.protection)}});
  return outcome;
}

std::unique_ptr<Stage> make_inventory_stage() {
  return make_function_stage<InventoryOptions>(
      {"inventory",
       {"fragility"},
       {"locate", "segment", "surface"},
       [](const StageInputs&, const InventoryOptions&) -> Estimate {
         return {std::uint64_t{512} << 20U, std::uint64_t{32} << 20U};
       },
       [](const StageInputs& in, const fs::path& stage_out, const InventoryOptions& options, base::RunContext& ctx) {
         fs::create_directories(stage_out / "inventory");
         const auto survey = io::read_survey(in.survey);
         const std::string name = survey.manifest.name.empty() ? "survey" : survey.manifest.name;
         return inventory_files(
             {{in.products, in.survey, name, std::string(base::kVersion), static_cast<std::int64_t>(ctx.seed)}},
             stage_out / "inventory", options, ctx);
       }});
}

}  // namespace cairn::pipeline
