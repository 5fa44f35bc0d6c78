#include "pipeline/executor.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <map>
#include <set>

#include "base/atomic_file.hpp"
#include "base/digest.hpp"
#include "base/error.hpp"
#include "base/version.hpp"

namespace cairn::pipeline {
namespace fs = std::filesystem;
namespace {

using base::Error;
using base::ErrorCode;
using io::Json;
using Clock = std::chrono::steady_clock;

constexpr std::string_view kStateFolder = ".cairn";

// Held for the whole run; the kernel drops it when the process dies.
class FolderLock {
 public:
  explicit FolderLock(const fs::path& path) : fd_(::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666)) {
    if (fd_ < 0)
      throw Error(ErrorCode::resource_exhausted,
                  std::string("cannot write in the output folder: ") + std::strerror(errno))
          .file(path.string())
          .hint("Check that the folder can be written");
    if (::flock(fd_, LOCK_EX | LOCK_NB) != 0) {
      ::close(fd_);
      throw Error(ErrorCode::failed_precondition, "another run is working in this folder")
          .file(path.parent_path().parent_path().string())
          .hint("Wait for it to end, or choose another output");
    }
  }
  ~FolderLock() { ::close(fd_); }
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

 private:
  int fd_;
};

struct Product {
  std::string path;  // relative to OUT
  std::string sha256;
};

struct Record {
  std::string key;
  std::vector<Product> products;
  Json summary;
  std::vector<base::Reject> rejects;
  std::vector<std::string> warnings;
};

fs::path record_path(const fs::path& out, std::string_view stage) {
  return out / kStateFolder / (std::string(stage) + ".json");
}

Json record_json(const Record& record) {
  Json products = Json::array();
  for (const auto& p : record.products) products.push(Json::object({{"path", p.path}, {"sha256", p.sha256}}));
  return Json::object({{"key", record.key},
                       {"products", products},
                       {"summary", record.summary},
                       {"rejects", to_json(record.rejects)},
                       {"warnings", Json(record.warnings)}});
}

// Empty where there is no record, or one that cannot be read: the stage then runs again.
Record read_record(const fs::path& path) {
  std::error_code code;
  if (!fs::exists(path, code)) return {};
  try {
    const Json json = io::read_json(path);
    Record record;
    record.key = json.at("key").as_string();
    for (const auto& p : json.at("products").as_array())
      record.products.push_back({p.at("path").as_string(), p.at("sha256").as_string()});
    record.summary = json.at("summary");
    for (const auto& r : json.at("rejects").as_array())
      record.rejects.push_back({r.at("record").as_string(), r.at("reason").as_string(), r.at("message").as_string()});
    for (const auto& w : json.at("warnings").as_array()) record.warnings.push_back(w.as_string());
    return record;
  } catch (const Error&) {
    return {};
  }
}

bool intact(const Record& record, const fs::path& out) {
  for (const auto& product : record.products) {
    std::error_code code;
    if (!fs::is_regular_file(out / product.path, code)) return false;
    if (base::sha256_of_file(out / product.path) != product.sha256) return false;
  }
  return true;
}

// What later stages may read: the products, and what the record tells about them (the report lists rejects).
std::string content_digest(const Record& record) {
  base::Digest digest;
  digest.add_field(record.summary.dump(0)).add_field(to_json(record.rejects).dump(0));
  digest.add_field(Json(record.warnings).dump(0));
  for (const auto& p : record.products) digest.add_field(p.path).add_field(p.sha256);
  return std::move(digest).hex();
}

struct Plan {
  std::vector<std::unique_ptr<Stage>> stages;
  std::vector<bool> optional;  // by stage
  std::string job_key;         // recipe, options, seed, survey
};

Plan make_plan(const Recipe& recipe, const StageFactory& factory, const std::string& survey_digest,
               std::uint64_t seed) {
  Plan plan;
  std::set<std::string> before;
  base::Digest job;
  job.add_field(base::kVersion).add_field(survey_digest).add_field(std::to_string(seed));
  for (const auto& item : recipe.stages) {
    auto stage = factory(item.stage);
    if (!stage)
      throw Error(ErrorCode::invalid_input, "unknown stage").record("recipe " + recipe.name).found(item.stage);
    for (const auto& need : stage->needs())
      if (!before.contains(need))
        throw Error(ErrorCode::invalid_input, "stage '" + item.stage + "' needs '" + need + "' before it")
            .record("recipe " + recipe.name);
    if (!before.insert(item.stage).second)
      throw Error(ErrorCode::invalid_input, "stage '" + item.stage + "' stands twice").record("recipe " + recipe.name);
    try {
      for (const auto& [name, value] : item.options) base::set_option(stage->options(), name, value);
    } catch (Error& e) {
      e.in("stage " + item.stage);
      throw;
    }
    base::validate(stage->options(), item.stage);
    job.add_field(item.stage);
    for (const auto& option : base::option_texts(stage->options())) job.add_field(option.name).add_field(option.value);
    if (item.optional) job.add_field("optional");
    plan.optional.push_back(item.optional);
    plan.stages.push_back(std::move(stage));
  }
  plan.job_key = std::move(job).hex();
  return plan;
}

std::string stage_key(Stage& stage, const std::string& survey_digest, std::uint64_t seed,
                      const std::map<std::string, std::string>& content) {
  base::Digest digest;
  digest.add_field(base::kVersion).add_field(stage.name()).add_field(survey_digest).add_field(std::to_string(seed));
  for (const auto& option : base::option_texts(stage.options())) digest.add_field(option.name).add_field(option.value);
  auto read = stage.needs();
  for (auto& used : stage.uses()) read.push_back(std::move(used));
  for (const auto& name : read) {
    const auto found = content.find(name);
    digest.add_field(name).add_field(found == content.end() ? "absent" : found->second);
  }
  return std::move(digest).hex();
}

void remove_products(const fs::path& out, const Record& record) {
  for (const auto& product : record.products) {
    std::error_code ignored;
    fs::remove(out / product.path, ignored);
  }
}

Record run_stage(Stage& stage, const StageInputs& in, const std::string& key, const fs::path& out,
                 const Record& previous, base::RunContext& ctx) {
  const fs::path record_file = record_path(out, stage.name());
  const fs::path work = out / kStateFolder / (std::string(stage.name()) + ".tmp");
  std::error_code code;
  fs::remove_all(work, code);
  fs::create_directories(work, code);
  if (code)
    throw Error(ErrorCode::resource_exhausted, "cannot create the folder: " + code.message()).file(work.string());

  const std::size_t warnings_before = ctx.warnings().size();
  Outcome outcome;
  try {
    outcome = stage.run(in, work, ctx);
  } catch (Error& e) {
    fs::remove_all(work, code);
    e.in("stage " + std::string(stage.name()));
    throw;
  } catch (...) {
    fs::remove_all(work, code);
    throw;
  }
  base::sync_tree(work);

  Record record{key, {}, std::move(outcome.summary), std::move(outcome.rejects), {}};
  record.warnings.assign(ctx.warnings().begin() + static_cast<std::ptrdiff_t>(warnings_before), ctx.warnings().end());
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(work))
    if (entry.is_regular_file()) files.push_back(fs::relative(entry.path(), work));
  std::sort(files.begin(), files.end());
  for (const auto& file : files) record.products.push_back({file.string(), base::sha256_of_file(work / file)});

  // From here to the new record, the old one must not vouch for a mixture of old and new products.
  fs::remove(record_file, code);
  remove_products(out, previous);
  for (const auto& file : files) {
    fs::create_directories((out / file).parent_path(), code);
    fs::rename(work / file, out / file, code);
    if (code)
      throw Error(ErrorCode::resource_exhausted, "cannot put the product in place: " + code.message())
          .file((out / file).string());
  }
  base::write_file_atomic(record_file, record_json(record).dump() + "\n");
  fs::remove_all(work, code);
  return record;
}

// The job that `out` was made by, "" where it holds none.
std::string job_in(const fs::path& out) {
  std::error_code code;
  const fs::path path = out / kStateFolder / "job.json";
  if (!fs::exists(path, code)) return "";
  try {
    return io::read_json(path).at("job").as_string();
  } catch (const Error&) {
    return "unreadable";
  }
}

// Nothing, or nothing but the state folder of a job that was stopped before its first record.
bool holds_nothing(const fs::path& out) {
  std::error_code code;
  if (!fs::exists(out, code)) return true;
  for (const auto& entry : fs::directory_iterator(out))
    if (entry.path().filename() != kStateFolder) return false;
  return true;
}

void claim_folder(const fs::path& out, const std::string& job_key, bool overwrite) {
  std::error_code code;
  if (fs::exists(out, code) && !fs::is_directory(out, code))
    throw Error(ErrorCode::already_exists, "the output folder's name is taken by a file").file(out.string());
  const std::string job = job_in(out);
  if (job == job_key || (job.empty() && holds_nothing(out))) return;
  if (job.empty())
    throw Error(ErrorCode::already_exists, "the folder was not made by 'cairn run' and is left alone")
        .file(out.string())
        .hint("Choose another output");
  if (!overwrite)
    throw Error(ErrorCode::already_exists, "the folder holds the result of another recipe, options, seed or survey")
        .file(out.string())
        .hint("Choose another output or add --overwrite");
}

// Products of stages that the new recipe does not have would lie about the new job.
void remove_other_stages(const fs::path& out, const Plan& plan) {
  std::set<std::string> kept{"job"};
  for (const auto& stage : plan.stages) kept.emplace(stage->name());
  std::vector<fs::path> stale;
  for (const auto& entry : fs::directory_iterator(out / kStateFolder))
    if (entry.path().extension() == ".json" && !kept.contains(entry.path().stem().string()))
      stale.push_back(entry.path());
  for (const auto& path : stale) {
    remove_products(out, read_record(path));
    fs::remove(path);
  }
}

}  // namespace

ExecuteReport execute(const Recipe& recipe, const StageFactory& factory, const std::vector<InputDigest>& inputs,
                      const ExecuteOptions& options, base::RunContext& ctx) {
  const auto started = std::chrono::system_clock::now();
  const auto start = Clock::now();
  const std::string survey_digest = combined_digest(inputs);
  Plan plan = make_plan(recipe, factory, survey_digest, ctx.seed);
  claim_folder(options.out, plan.job_key, options.overwrite);

  const fs::path run_json = options.out / "run.json";
  std::unique_ptr<FolderLock> lock;
  if (!options.dry_run) {
    std::error_code code;
    fs::create_directories(options.out / kStateFolder, code);
    if (code)
      throw Error(ErrorCode::resource_exhausted, "cannot create the output folder: " + code.message())
          .file(options.out.string())
          .hint("Check that the folder can be written");
    lock = std::make_unique<FolderLock>(options.out / kStateFolder / "lock");
  }

  ExecuteReport report;
  report.nothing_to_do = fs::exists(run_json) && job_in(options.out) == plan.job_key;
  std::map<std::string, std::string> content;
  std::vector<Record> records;
  StageInputs in{options.survey, options.out, {}};
  bool claimed = false;
  // run.json vouches for the whole: it goes before anything changes and comes back last.
  const auto claim = [&] {
    std::error_code code;
    fs::remove(run_json, code);
    remove_other_stages(options.out, plan);
    base::write_file_atomic(options.out / kStateFolder / "job.json",
                            Json::object({{"job", plan.job_key}}).dump() + "\n");
    claimed = true;
  };
  if (!options.dry_run && job_in(options.out) != plan.job_key) claim();
  for (std::size_t i = 0; i < plan.stages.size(); ++i) {
    ctx.check_stop();
    auto& stage = plan.stages[i];
    const std::string name(stage->name());
    if (const std::string lacks = plan.optional[i] ? stage->missing(in) : std::string(); !lacks.empty()) {
      Record stale = read_record(record_path(options.out, name));
      if (!options.dry_run && !stale.key.empty()) {
        report.nothing_to_do = false;
        if (!claimed) claim();
        remove_products(options.out, stale);
        fs::remove(record_path(options.out, name));
      }
      report.stages.push_back({name, "skipped: no " + lacks, 0.0, {}, {}});
      records.emplace_back();
      continue;
    }
    const std::string key = stage_key(*stage, survey_digest, ctx.seed, content);
    Record record = read_record(record_path(options.out, name));
    StageReport line{name, "kept", 0.0, stage->estimate(in), {}};
    if (record.key != key || !intact(record, options.out)) {
      report.nothing_to_do = false;
      if (options.dry_run) {
        line.state = "would run";
        record = {};
      } else {
        if (!claimed) claim();
        ctx.info(name);
        const auto stage_start = Clock::now();
        record = run_stage(*stage, in, key, options.out, record, ctx);
        line.state = "ran";
        line.seconds = std::chrono::duration<double>(Clock::now() - stage_start).count();
      }
    }
    line.summary = record.summary;
    // A stage that only would run has no content yet: what reads it would run as well.
    content[name] = options.dry_run && line.state == "would run" ? "planned" : content_digest(record);
    in.available.push_back(name);
    records.push_back(std::move(record));
    report.stages.push_back(std::move(line));
  }
  if (options.dry_run || report.nothing_to_do) return report;

  RunRecord run{"run", options.arguments, ctx.seed, inputs, Json::object(), {}, {}, Json::object()};
  Json stages = Json::array();
  for (std::size_t i = 0; i < records.size(); ++i) {
    const Record& record = records[i];
    Json stage_options = Json::object();
    for (const auto& option : base::option_texts(plan.stages[i]->options()))
      stage_options.set(option.name, option.quoted ? Json(option.value) : io::parse_json(option.value, option.name));
    Json products = Json::array();
    for (const auto& p : record.products) products.push(Json::object({{"path", p.path}, {"sha256", p.sha256}}));
    stages.push(Json::object({{"stage", report.stages[i].name},
                              {"state", report.stages[i].state},
                              {"seconds", report.stages[i].seconds},
                              {"options", stage_options},
                              {"summary", record.summary},
                              {"products", products}}));
    run.summary.set(report.stages[i].name, record.summary);
    run.rejects.insert(run.rejects.end(), record.rejects.begin(), record.rejects.end());
    run.warnings.insert(run.warnings.end(), record.warnings.begin(), record.warnings.end());
  }
  run.extra = Json::object({{"recipe", recipe.name}, {"job", plan.job_key}, {"stages", stages}});
  base::write_file_atomic(
      run_json, to_json(run, started, std::chrono::duration<double>(Clock::now() - start).count()).dump() + "\n");
  return report;
}

}  // namespace cairn::pipeline
