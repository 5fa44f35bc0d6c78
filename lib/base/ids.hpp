// Integer ids that cannot be mixed up with one another.
#pragma once

#include <compare>
#include <cstdint>
#include <functional>

namespace cairn::base {

// Id of a record kind named by Tag. Valid ids are >= 0; a default-built id is invalid.
template <typename Tag>
struct Id {
  std::int64_t value = -1;

  constexpr Id() = default;
  constexpr explicit Id(std::int64_t v) : value(v) {}

  [[nodiscard]] constexpr bool valid() const noexcept { return value >= 0; }
  friend constexpr auto operator<=>(const Id&, const Id&) = default;
};

}  // namespace cairn::base

template <typename Tag>
struct std::hash<cairn::base::Id<Tag>> {
  std::size_t operator()(const cairn::base::Id<Tag>& id) const noexcept { return std::hash<std::int64_t>{}(id.value); }
};
