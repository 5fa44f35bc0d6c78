// Runs the built `cairn` as a user would.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace cairn::testing {

struct ProgramResult {
  int exit_code = -1;  // 128 + signal where a signal ended it
  std::string out, err;
};

// Arguments are passed as they are (no shell). `environment` is added to the current one.
[[nodiscard]] ProgramResult run_program(const std::filesystem::path& program, const std::vector<std::string>& arguments,
                                        const std::map<std::string, std::string>& environment = {});

// The `cairn` of this build.
[[nodiscard]] ProgramResult cairn(const std::vector<std::string>& arguments,
                                  const std::map<std::string, std::string>& environment = {});

}  // namespace cairn::testing
