// cairn check SURVEY
#include "base/number_text.hpp"
#include "pipeline/check.hpp"
#include "tools/command.hpp"

namespace cairn::tools {
namespace {

std::string plural(std::size_t count, const std::string& noun) {
  return std::to_string(count) + " " + noun + (count == 1 ? "" : "s");
}

std::string text_of(const pipeline::CheckResult& result, const std::filesystem::path& survey) {
  std::string text;
  std::size_t errors = 0, warnings = 0;
  for (const auto& f : result.findings) {
    errors += f.severity == pipeline::Severity::error ? 1 : 0;
    warnings += f.severity == pipeline::Severity::warning ? 1 : 0;
    text += std::string(pipeline::name_of(f.severity)) + " " + f.code + ": ";
    if (!f.file.empty()) text += f.file;
    if (!f.record.empty()) text += ", " + f.record;
    text += ": " + f.message + ".";
    if (!f.hint.empty()) text += " " + f.hint + ".";
    text += "\n";
  }
  const auto figure = [&](const char* member, const char* name, const std::string& label, const std::string& unit) {
    const auto* group = result.evidence.find(member);
    const auto* value = group == nullptr ? nullptr : group->find(name);
    if (value != nullptr && value->is_number())
      text += "  " + label + ": " + base::to_fixed(value->as_real(), 2) + " " + unit + "\n";
  };
  text += "Evidence:\n";
  figure("height_above_ground", "median_m", "median height above the ground", "m");
  figure("tie_points_reprojection", "median_px", "median reprojection error of the tie points", "px");
  figure("image_pairs", "median_disagreement_corrected_m", "median disagreement of neighbouring images", "m");
  const auto* offset = result.evidence.find("cloud_offset");
  if (offset != nullptr && offset->at("horizontal_determined").as_bool()) {
    figure("cloud_offset", "east_m", "cloud minus poses, east", "m");
    figure("cloud_offset", "north_m", "cloud minus poses, north", "m");
    figure("cloud_offset", "up_m", "cloud minus poses, up", "m");
  } else if (offset != nullptr) {
    text += "  cloud minus poses: not determined\n";
  }
  text += survey.string() + (result.ok ? " is sound: " : " is not sound: ") + plural(errors, "error") + ", " +
          plural(warnings, "warning") + "\n";
  return text;
}

class CheckCommand final : public Command {
 public:
  void declare(Arguments& arguments) override {
    arguments.input("survey", survey_, "Survey folder");
    arguments.options(base::bind_options(options_));
    arguments.example("cairn check survey");
    arguments.example("cairn check survey --json --pixels false");
  }

  CommandResult run(const Arguments& arguments, base::RunContext& ctx) override {
    base::validate(base::bind_options(options_), "check");
    if (arguments.common.dry_run)
      return {io::Json::object({{"would_check", survey_.string()}}), "Would check " + survey_.string() + "\n"};
    const auto result = pipeline::check_survey(survey_, options_, ctx);
    return {result.to_json(), text_of(result, survey_), result.ok ? base::ExitCode::ok : base::ExitCode::invalid_input};
  }

 private:
  std::filesystem::path survey_;
  pipeline::CheckOptions options_;
};

}  // namespace
}  // namespace cairn::tools

CAIRN_COMMAND_MAIN(cairn::tools::CheckCommand)
