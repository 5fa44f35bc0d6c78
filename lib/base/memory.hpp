// Memory of this process and of this machine.
#pragma once

#include <cstdint>

namespace cairn::base {

// Resident set now and at its peak [bytes]; 0 where the system does not tell.
[[nodiscard]] std::uint64_t resident_bytes();
[[nodiscard]] std::uint64_t peak_resident_bytes();

}  // namespace cairn::base
