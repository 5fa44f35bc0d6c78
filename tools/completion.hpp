// Shell completion.
#pragma once

#include <string>

namespace cairn::tools {

// A bash script: subcommands from the registry, options from `cairn <subcommand> --json-usage`.
[[nodiscard]] std::string bash_completion();

}  // namespace cairn::tools
