// A result as the inventory reads it. Internal to the stage.
#pragma once

#include "base/run_context.hpp"
#include "pipeline/inventory_stage.hpp"
#include "report/inventory.hpp"

namespace cairn::pipeline {

// Adds the survey and its rocks. Mesh files by index of the rock, "" where it has none, stand in `meshes`.
void add_result(report::Inventory& inventory, std::vector<std::filesystem::path>& meshes, const InventorySource& source,
                base::RunContext& ctx);

}  // namespace cairn::pipeline
