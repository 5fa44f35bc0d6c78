#include "report/layer_looks.hpp"

#include <array>
#include <set>
#include <string>
#include <utility>

namespace cairn::report {
namespace {

using io::Colour;

constexpr Colour kVermillion{213, 94, 0, 255}, kGreen{0, 158, 115, 255}, kSky{86, 180, 233, 255},
    kPurple{204, 121, 167, 255}, kOrange{230, 159, 0, 255}, kBlue{0, 114, 178, 255}, kGrey{153, 153, 153, 255},
    kYellow{240, 228, 66, 255};

constexpr std::array<std::pair<std::string_view, Colour>, 8> kClassColours{{{"boulder", kVermillion},
                                                                            {"rock", kVermillion},
                                                                            {"pbr", kVermillion},
                                                                            {"tree", kGreen},
                                                                            {"car", kSky},
                                                                            {"vehicle", kSky},
                                                                            {"bench", kPurple},
                                                                            {"table", kOrange}}};
constexpr std::array<Colour, 6> kFree{kPurple, kOrange, kBlue, kYellow, kSky, kGreen};

Colour class_colour(std::string_view name, std::size_t& next_free) {
  for (const auto& [known, colour] : kClassColours)
    if (known == name) return colour;
  return kFree[next_free++ % kFree.size()];
}

Colour faded(Colour colour, std::uint8_t alpha) {
  colour.alpha = alpha;
  return colour;
}

// One entry a value that occurs, in the order of the names.
std::vector<io::StyleClass> classes_by_value(const io::Layer& layer, std::string_view column, std::uint8_t alpha) {
  const std::size_t index = layer.column(column);
  std::set<std::string> values;
  for (const auto& feature : layer.features) values.insert(io::to_text(feature.values[index]));
  std::vector<io::StyleClass> classes;
  std::size_t next_free = 0;
  for (const auto& value : values)
    if (!value.empty()) classes.push_back({value, value, faded(class_colour(value, next_free), alpha)});
  return classes;
}

}  // namespace

io::LayerStyle look_of(const io::Layer& layer) {
  io::LayerStyle style;
  style.other = kGrey;
  if (layer.name == "targets") {
    style.name = "by class";
    style.column = "class";
    style.classes = classes_by_value(layer, "class", 255);
    style.label_column = "id";
  } else if (layer.name == "rocks" || layer.name == "inventory") {
    style.name = "by grade";
    style.column = "grade";
    style.classes = {{"measured", "measured", kGreen},
                     {"bounded", "bounded", kBlue},
                     {"screening", "screening (contact assumed)", kOrange},
                     {"not_measurable", "not measurable", kGrey}};
    style.marker = "diamond";
    style.marker_mm = 4.0;
    style.label_column = "name";
  } else if (layer.name == "obstacles") {
    style.name = "by kind";
    style.column = "kind";
    style.classes = {{"obstacle", "obstacle", kVermillion},
                     {"ignored", "ignored (passable below)", kGreen},
                     {"vehicle", "vehicle", kSky}};
    style.marker = "square";
  } else if (layer.name == "frames") {
    style.name = "frames";
    style.other = kBlue;
    style.marker = "triangle";
    style.marker_mm = 2.5;
  } else if (layer.name == "footprints") {
    style.name = "footprints";
    style.other = faded(kBlue, 20);
    style.outline = faded(kBlue, 120);
    style.outline_mm = 0.2;
  } else if (layer.name == "gaps") {
    style.name = "by reason";
    style.column = "reason";
    style.classes = classes_by_value(layer, "reason", 120);
    style.other = faded(kGrey, 120);
  }
  return style;
}

}  // namespace cairn::report
