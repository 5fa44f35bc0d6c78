#include "pipeline/plan_audited.hpp"

#include <algorithm>
#include <cstdint>
#include <string_view>

#include "base/error.hpp"
#include "base/options.hpp"
#include "io/json.hpp"
#include "io/targets_json.hpp"

namespace cairn::pipeline {
namespace fs = std::filesystem;
namespace {

using base::Error;
using base::ErrorCode;

fs::path named(const io::Json& arguments, const char* name) {
  const io::Json* value = arguments.find(name);
  return value != nullptr && value->is_string() ? fs::path(value->as_string()) : fs::path();
}

// Options of the audit, as run.json has them.
class FromArguments final : public base::OptionVisitor {
 public:
  explicit FromArguments(const io::Json& arguments) : arguments_(arguments) {}
  void real(std::string_view name, double& value, double, double, std::string_view) override {
    if (const io::Json* json = arguments_.find(name); json != nullptr && json->is_number()) value = json->as_real();
  }
  void integer(std::string_view name, std::int64_t& value, std::int64_t, std::int64_t, std::string_view) override {
    if (const io::Json* json = arguments_.find(name); json != nullptr && json->is_integer()) value = json->as_integer();
  }
  void flag(std::string_view, bool&, std::string_view) override {}
  void choice(std::string_view, std::string&, const std::vector<std::string>&, std::string_view) override {}
  void text(std::string_view, std::string&, std::string_view) override {}

 private:
  const io::Json& arguments_;
};

}  // namespace

Audited read_audited(const PlanInputs& in) {
  const fs::path record = in.coverage / "run.json";
  if (!fs::exists(record))
    throw Error(ErrorCode::not_found, "this is no result of 'cairn coverage'")
        .file(in.coverage.string())
        .hint("Give the folder that 'cairn coverage' or 'cairn run' wrote");
  const io::Json run = io::read_json(record);
  Audited audited;
  const io::Json* command = run.find("command");
  if (command != nullptr && command->is_string() && command->as_string() == "coverage") {
    const io::Json& arguments = run.at("arguments");
    audited.surface = named(arguments, "surface");
    audited.views = named(arguments, "views");
    audited.targets = named(arguments, "targets");
    audited.contacts = named(arguments, "contacts");
    if (const fs::path format = named(arguments, "format"); !format.empty()) audited.format = format.string();
    FromArguments visitor(arguments);
    audited.visibility.visit(visitor);
    audited.gates.visit(visitor);
    audited.gaps.visit(visitor);
    audited.target_options.visit(visitor);
  } else {
    // A recipe's products.
    if (const io::Json* arguments = run.find("arguments")) audited.views = named(*arguments, "survey");
    if (fs::exists(in.coverage / "surface.tif")) audited.surface = in.coverage / "surface.tif";
    if (fs::exists(in.coverage / "targets.json")) audited.targets = in.coverage / "targets.json";
  }
  if (!in.terrain.empty()) audited.surface = in.terrain;
  if (!in.survey.empty()) audited.views = in.survey;
  if (!in.targets.empty()) audited.targets = in.targets;
  const auto needed = [&](const fs::path& path, const char* what, const char* option) {
    if (!path.empty() && fs::exists(path)) return;
    throw Error(ErrorCode::not_found, std::string("the audit's ") + what + " is not there")
        .file(path.empty() ? record.string() : path.string())
        .hint(std::string("Give it with ") + option + ", or run from the folder the audit was run in");
  };
  needed(audited.surface, "surface", "--terrain");
  needed(audited.views, "views", "--survey");
  if (!audited.targets.empty()) needed(audited.targets, "file of targets", "--targets");
  return audited;
}

void keep_classes(std::vector<coverage::TargetBody>& bodies, std::vector<base::Reject>& rejects,
                  const fs::path& targets, const std::string& classes) {
  if (classes.empty()) return;
  const io::TargetsFile file = io::read_targets(targets);
  const auto other = [&](const std::string& name) {
    return ("," + classes + ",").find("," + name + ",") == std::string::npos;
  };
  std::erase_if(bodies, [&](const coverage::TargetBody& body) {
    const survey::Target* target = file.find(body.id);
    return target == nullptr || other(target->object_class);
  });
  std::erase_if(rejects, [&](const base::Reject& reject) {
    return std::any_of(file.targets.begin(), file.targets.end(), [&](const survey::Target& t) {
      return other(t.object_class) && reject.record == "target " + std::to_string(t.id.value);
    });
  });
}

}  // namespace cairn::pipeline
