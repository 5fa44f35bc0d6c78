// Runs a recipe: each stage once, resumable by content.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "base/run_context.hpp"
#include "pipeline/recipe.hpp"
#include "pipeline/run_record.hpp"
#include "pipeline/stage.hpp"

namespace cairn::pipeline {

// Makes the stage of a name, or nullptr.
using StageFactory = std::function<std::unique_ptr<Stage>(std::string_view name)>;

struct ExecuteOptions {
  std::filesystem::path survey;
  std::filesystem::path out;
  bool overwrite = false;  // a different recipe or survey may replace what is in `out`
  bool dry_run = false;
  io::Json arguments;  // for run.json
};

struct StageReport {
  std::string name;
  std::string state;  // "ran", "kept", "would run", "skipped: no detections"
  double seconds = 0.0;
  Estimate estimate;
  io::Json summary;
};

struct ExecuteReport {
  bool nothing_to_do = false;
  std::vector<StageReport> stages;
};

// Keys. A stage's key is a hash over cairn's version, the stage's name and options, the seed, the
// survey's content and the products of the stages it reads. OUT/.cairn/<stage>.json keeps the key
// and the hash of every product; a stage is kept when its key and all its products still agree, by
// content and never by time. Its products move to their final names by rename, its record comes
// last, so that a kill at any moment costs at most the stage that was running. run.json is the last
// file of all.
//
// `out` that holds another job (other recipe, options, seed or survey): already_exists unless
// overwrite. Two runs in one folder at once: the second is refused.
// inputs: digests of the survey and everything it refers to.
ExecuteReport execute(const Recipe& recipe, const StageFactory& factory, const std::vector<InputDigest>& inputs,
                      const ExecuteOptions& options, base::RunContext& ctx);

}  // namespace cairn::pipeline
