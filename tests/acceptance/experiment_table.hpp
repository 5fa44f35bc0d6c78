// The results of many seeds, pooled, as Markdown.
#pragma once

#include <string>
#include <vector>

#include "io/json.hpp"

namespace cairn::acceptance {

// Lines of one grade. Proportions with Wilson's 95 % interval, medians with a bootstrap over seeds.
[[nodiscard]] std::string pooled_tables(const std::vector<io::Json>& lines, const std::string& grade);

}  // namespace cairn::acceptance
