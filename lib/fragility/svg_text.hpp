// Text for SVG.
#pragma once

#include <string>
#include <string_view>

namespace cairn::fragility {

// The characters <, > and & as entities: for text between tags, not for attributes.
[[nodiscard]] std::string escaped(std::string_view text);

}  // namespace cairn::fragility
