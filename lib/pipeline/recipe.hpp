// A whole job as data: pipelines/*.json.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace cairn::pipeline {

// One stage with the options that differ from the defaults, as text ("0.25", "robust").
struct RecipeStage {
  std::string stage;
  std::vector<std::pair<std::string, std::string>> options;
  bool optional = false;  // left out where the survey lacks what the stage works on (a cloud has no detections)
};

struct Recipe {
  std::string name;
  std::string description;
  std::vector<RecipeStage> stages;  // in the order they run
};

// {"schema_version": 1, "name", "description", "stages": [{"stage": "locate", "options": {...},
// "optional": true}]}.
// Throws invalid_input naming the member where something is missing, unknown or of the wrong kind.
[[nodiscard]] Recipe read_recipe(const std::filesystem::path& path);

// Applies "stage.option=value". Throws invalid_argument where the recipe has no such stage.
void apply_setting(Recipe& recipe, std::string_view setting);

}  // namespace cairn::pipeline
