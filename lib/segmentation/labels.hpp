// The labels of a segmented cloud, as they stand in column `label`.
#pragma once

#include <cstdint>

namespace cairn::segmentation {

enum class Label : std::uint8_t { unlabelled = 0, terrain = 1, rock = 2, pedestal = 3, basal_contact = 4 };

inline constexpr const char* kLabelColumn = "label";              // u8
inline constexpr const char* kTargetIdColumn = "target_id";       // u32; kNoTarget where none
inline constexpr const char* kProbabilityColumn = "probability";  // f32, of the label, 0..1
inline constexpr std::uint32_t kNoTarget = 0xffffffffU;           // ids start at 0, so 0 cannot mean "none"

}  // namespace cairn::segmentation
