// run.json: how a product came about. Written beside every output, last.
#pragma once

#include <chrono>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "base/run_context.hpp"
#include "io/json.hpp"
#include "pipeline/outcome.hpp"

namespace cairn::pipeline {

// SHA-256 of one input, with its size.
struct InputDigest {
  std::string path;  // as given
  std::string sha256;
  std::uint64_t bytes = 0;
};

// A file, or every file below a folder, sorted by path. Throws not_found.
[[nodiscard]] std::vector<InputDigest> digest_inputs(const std::vector<std::filesystem::path>& inputs);
// One hash over paths' last parts and contents: equal inputs give equal hashes wherever they lie.
[[nodiscard]] std::string combined_digest(const std::vector<InputDigest>& inputs);

struct RunRecord {
  std::string command;  // "locate"
  io::Json arguments;   // resolved options
  std::uint64_t seed = 0;
  std::vector<InputDigest> inputs;
  io::Json summary;
  std::vector<base::Reject> rejects;
  std::vector<std::string> warnings;
  io::Json extra;  // members added as they are: CRS operations, stages
};

// Time stamps and timings stand here and nowhere else.
[[nodiscard]] io::Json to_json(const RunRecord& record, std::chrono::system_clock::time_point started, double seconds);

// Runs `stage` into a staged folder beside `out`, adds run.json, and publishes the folder by one rename.
// Throws already_exists where `out` is there and overwrite is false; with overwrite, replaces only
// folders that carry a run.json (nothing that cairn did not make is ever removed).
Outcome run_to_folder(const std::filesystem::path& out, bool overwrite, RunRecord record,
                      const std::function<Outcome(const std::filesystem::path& staged)>& stage, base::RunContext& ctx);

// The same for a single file: run.json stands beside it as <file>.run.json.
Outcome run_to_file(const std::filesystem::path& out, bool overwrite, RunRecord record,
                    const std::function<Outcome(const std::filesystem::path& staged)>& stage, base::RunContext& ctx);

// Throws already_exists / failed_precondition as run_to_folder would; for checks before long work.
void check_output_folder(const std::filesystem::path& out, bool overwrite);

}  // namespace cairn::pipeline
