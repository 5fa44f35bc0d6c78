#include "survey/edit.hpp"

#include <array>
#include <utility>

namespace cairn::survey {
namespace {

constexpr std::array<std::pair<EditAction, std::string_view>, 7> kActions{{{EditAction::accept, "accept"},
                                                                           {EditAction::reject, "reject"},
                                                                           {EditAction::merge, "merge"},
                                                                           {EditAction::split, "split"},
                                                                           {EditAction::reclassify, "reclassify"},
                                                                           {EditAction::set, "set"},
                                                                           {EditAction::note, "note"}}};

}  // namespace

std::string_view name_of(EditAction action) {
  for (const auto& [known, name] : kActions)
    if (known == action) return name;
  return "unknown";
}

std::optional<EditAction> edit_action_from(std::string_view name) {
  for (const auto& [action, known] : kActions)
    if (known == name) return action;
  return std::nullopt;
}

}  // namespace cairn::survey
