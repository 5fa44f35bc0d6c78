// All subcommands. The list itself stands in tools/CMakeLists.txt.
#pragma once

#include <span>
#include <string_view>

namespace cairn::tools {

struct RegistryEntry {
  std::string_view name;
  std::string_view summary;
};

[[nodiscard]] std::span<const RegistryEntry> registry();

}  // namespace cairn::tools
