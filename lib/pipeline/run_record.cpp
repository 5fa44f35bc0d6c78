#include "pipeline/run_record.hpp"

#include <algorithm>

#include "base/atomic_file.hpp"
#include "base/digest.hpp"
#include "base/error.hpp"
#include "base/memory.hpp"
#include "base/time.hpp"
#include "base/version.hpp"

namespace cairn::pipeline {
namespace fs = std::filesystem;

namespace {

InputDigest digest_file(const fs::path& path) {
  std::error_code code;
  const auto bytes = fs::file_size(path, code);
  return {path.string(), base::sha256_of_file(path), code ? 0 : bytes};
}

io::Json inputs_json(const std::vector<InputDigest>& inputs) {
  io::Json list = io::Json::array();
  for (const auto& input : inputs)
    list.push(io::Json::object(
        {{"path", input.path}, {"sha256", input.sha256}, {"bytes", static_cast<std::int64_t>(input.bytes)}}));
  return list;
}

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace

std::vector<InputDigest> digest_inputs(const std::vector<fs::path>& inputs) {
  std::vector<InputDigest> digests;
  for (const auto& input : inputs) {
    if (!fs::is_directory(input)) {
      digests.push_back(digest_file(input));
      continue;
    }
    std::vector<fs::path> files;
    for (const auto& entry : fs::recursive_directory_iterator(input))
      if (entry.is_regular_file() && entry.path().filename() != "run.json") files.push_back(entry.path());
    std::sort(files.begin(), files.end());
    for (const auto& file : files) digests.push_back(digest_file(file));
  }
  return digests;
}

std::string combined_digest(const std::vector<InputDigest>& inputs) {
  base::Digest digest;
  for (const auto& input : inputs) digest.add_field(fs::path(input.path).filename().string()).add_field(input.sha256);
  return std::move(digest).hex();
}

io::Json to_json(const RunRecord& record, std::chrono::system_clock::time_point started, double seconds) {
  const auto since_epoch = std::chrono::duration_cast<std::chrono::nanoseconds>(started.time_since_epoch()).count();
  io::Json json = io::Json::object({{"cairn_version", base::kVersion},
                                    {"command", record.command},
                                    {"arguments", record.arguments},
                                    {"seed", static_cast<std::int64_t>(record.seed)},
                                    {"inputs", inputs_json(record.inputs)},
                                    {"summary", record.summary},
                                    {"rejects_by_reason", count_by_reason(record.rejects)},
                                    {"rejects", to_json(record.rejects)},
                                    {"warnings", io::Json(record.warnings)}});
  if (record.extra.is_object())
    for (const auto& [key, value] : record.extra.as_object()) json.set(key, value);
  json.set("started_utc", base::iso8601(since_epoch));
  json.set("seconds", seconds);
  json.set("peak_rss_bytes", static_cast<std::int64_t>(base::peak_resident_bytes()));
  return json;
}

void check_output_folder(const fs::path& out, bool overwrite) {
  std::error_code code;
  if (!fs::exists(out, code)) return;
  if (!fs::is_directory(out, code))
    throw base::Error(base::ErrorCode::already_exists, "the output folder's name is taken by a file")
        .file(out.string())
        .hint("Choose another name");
  if (fs::is_empty(out, code)) return;
  if (!overwrite)
    throw base::Error(base::ErrorCode::already_exists, "output exists")
        .file(out.string())
        .hint("Choose another name or add --overwrite");
  if (!fs::exists(out / "run.json", code))
    throw base::Error(base::ErrorCode::already_exists, "the folder was not made by cairn and is left alone")
        .file(out.string())
        .found("no run.json in it")
        .hint("Choose another name, or remove the folder yourself");
}

Outcome run_to_folder(const fs::path& out, bool overwrite, RunRecord record,
                      const std::function<Outcome(const fs::path&)>& stage, base::RunContext& ctx) {
  check_output_folder(out, overwrite);
  const auto started = std::chrono::system_clock::now();
  const auto start = std::chrono::steady_clock::now();
  base::StagedFolder staged(out, overwrite);
  Outcome outcome = stage(staged.path());
  record.summary = outcome.summary;
  record.rejects = outcome.rejects;
  record.warnings = ctx.warnings();
  base::write_file(staged.path() / "run.json", to_json(record, started, seconds_since(start)).dump() + "\n");
  staged.commit();
  return outcome;
}

Outcome run_to_file(const fs::path& out, bool overwrite, RunRecord record,
                    const std::function<Outcome(const fs::path&)>& stage, base::RunContext& ctx) {
  const auto started = std::chrono::system_clock::now();
  const auto start = std::chrono::steady_clock::now();
  base::StagedFile staged(out, overwrite);
  Outcome outcome = stage(staged.path());
  record.summary = outcome.summary;
  record.rejects = outcome.rejects;
  record.warnings = ctx.warnings();
  staged.commit();
  base::write_file_atomic(out.string() + ".run.json", to_json(record, started, seconds_since(start)).dump() + "\n");
  return outcome;
}

}  // namespace cairn::pipeline
