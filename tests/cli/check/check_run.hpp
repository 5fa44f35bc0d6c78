// Runs `cairn check` and looks into what it said.
#pragma once

#include <gmock/gmock.h>

#include <string>
#include <vector>

#include "io/json.hpp"
#include "support/check_survey.hpp"
#include "support/run_program.hpp"

namespace cairn::testing {

struct CheckRun {
  int exit_code = -1;
  io::Json json;
  std::string err;

  [[nodiscard]] bool ok() const { return json.at("ok").as_bool(); }
  [[nodiscard]] std::vector<io::Json> findings(const std::string& code) const {
    std::vector<io::Json> result;
    for (const auto& finding : json.at("findings").as_array())
      if (finding.at("code").as_string() == code) result.push_back(finding);
    return result;
  }
  [[nodiscard]] std::vector<std::string> codes(const std::string& severity) const {
    std::vector<std::string> result;
    for (const auto& finding : json.at("findings").as_array())
      if (finding.at("severity").as_string() == severity) result.push_back(finding.at("code").as_string());
    return result;
  }
};

inline CheckRun check(const std::filesystem::path& survey, std::vector<std::string> more = {}) {
  std::vector<std::string> arguments{"check", survey.string(), "--json"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  const auto result = cairn(arguments);
  CheckRun run{result.exit_code, {}, result.err};
  run.json = io::parse_json(result.out, "stdout of cairn check");
  return run;
}

}  // namespace cairn::testing
