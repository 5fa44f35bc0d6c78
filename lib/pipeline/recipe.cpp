#include "pipeline/recipe.hpp"

#include <algorithm>

#include "base/error.hpp"
#include "io/json.hpp"

namespace cairn::pipeline {
namespace {

using base::Error;
using base::ErrorCode;

void refuse_unknown(const io::Json& object, const std::vector<std::string_view>& known, std::string_view where) {
  std::string allowed;
  for (const auto name : known) allowed += (allowed.empty() ? "" : ", ") + std::string(name);
  for (const auto& [key, value] : object.as_object())
    if (std::find(known.begin(), known.end(), key) == known.end())
      throw Error(ErrorCode::invalid_input, "unknown member").record(where).found("'" + key + "'").allowed(allowed);
}

void set_option_text(RecipeStage& stage, const std::string& name, const std::string& value) {
  for (auto& [known, text] : stage.options)
    if (known == name) {
      text = value;
      return;
    }
  stage.options.emplace_back(name, value);
}

}  // namespace

Recipe read_recipe(const std::filesystem::path& path) {
  const io::Json json = io::read_json(path);
  try {
    refuse_unknown(json, {"schema_version", "name", "description", "stages"}, "recipe");
    const std::int64_t version = json.at("schema_version").as_integer();
    if (version != 1)
      throw Error(ErrorCode::invalid_input, "unknown schema version").found(std::to_string(version)).allowed("1");
    Recipe recipe;
    recipe.name = json.at("name").as_string();
    if (const auto* description = json.find("description")) recipe.description = description->as_string();
    for (const auto& item : json.at("stages").as_array()) {
      refuse_unknown(item, {"stage", "options", "optional"}, "stage " + std::to_string(recipe.stages.size() + 1));
      RecipeStage stage{item.at("stage").as_string(), {}, false};
      if (const auto* optional = item.find("optional")) stage.optional = optional->as_bool();
      if (const auto* options = item.find("options"))
        for (const auto& [name, value] : options->as_object())
          stage.options.emplace_back(name, value.is_string() ? value.as_string() : value.dump(0));
      recipe.stages.push_back(std::move(stage));
    }
    if (recipe.stages.empty()) throw Error(ErrorCode::invalid_input, "the recipe has no stages");
    return recipe;
  } catch (Error& e) {
    e.default_file(path.string());
    throw;
  }
}

void apply_setting(Recipe& recipe, std::string_view setting) {
  const auto dot = setting.find('.');
  const auto equals = setting.find('=');
  if (dot == std::string_view::npos || equals == std::string_view::npos || equals < dot)
    throw Error(ErrorCode::invalid_argument, "--set needs stage.option=value").found("'" + std::string(setting) + "'");
  const std::string_view stage_name = setting.substr(0, dot);
  std::string known;
  for (auto& stage : recipe.stages) {
    if (stage.stage == stage_name) {
      set_option_text(stage, std::string(setting.substr(dot + 1, equals - dot - 1)),
                      std::string(setting.substr(equals + 1)));
      return;
    }
    known += (known.empty() ? "" : ", ") + stage.stage;
  }
  throw Error(ErrorCode::invalid_argument, "the recipe has no such stage")
      .found("'" + std::string(stage_name) + "'")
      .allowed(known);
}

}  // namespace cairn::pipeline
