// The site's figures. Internal to the stage `inventory`.
#pragma once

#include <filesystem>
#include <vector>

#include "base/run_context.hpp"
#include "io/vector_layer.hpp"
#include "pipeline/inventory_stage.hpp"
#include "report/inventory.hpp"

namespace cairn::pipeline {

// index.html, contact_sheet.svg, grades.svg and, where nothing is protected and all rocks stand in one frame, map.svg.
// meshes: by index of the rock, "" = none.
void write_site(const report::Inventory& inventory, const std::vector<std::filesystem::path>& meshes,
                const std::filesystem::path& out, const InventoryOptions& options, base::RunContext& ctx);

}  // namespace cairn::pipeline
