// How each layer looks in QGIS and in KML viewers.
#pragma once

#include <string_view>
#include <vector>

#include "io/layer_style.hpp"
#include "io/vector_layer.hpp"

namespace cairn::report {

// targets and obstacles by class or kind, rocks by grade, gaps by reason; frames and footprints plain.
// Colours are those of Okabe and Ito (2008), told apart with any colour vision. Classes that are not
// known take the next free colour in the order of their names. `layer` has its features already.
[[nodiscard]] io::LayerStyle look_of(const io::Layer& layer);

}  // namespace cairn::report
