// The page's script and style sheet, built from web/ and held in the program.
#pragma once

#include <string_view>

namespace cairn::report {

[[nodiscard]] std::string_view bundle_script();
[[nodiscard]] std::string_view bundle_style();

}  // namespace cairn::report
