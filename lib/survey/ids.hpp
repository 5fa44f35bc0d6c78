// Ids of the records. Integers, unique within one survey, persistent across re-runs.
#pragma once

#include "base/ids.hpp"

namespace cairn::survey {

using CameraId = base::Id<struct CameraTag>;
using FrameId = base::Id<struct FrameTag>;
using DetectionId = base::Id<struct DetectionTag>;
using TrackId = base::Id<struct TrackTag>;
using TargetId = base::Id<struct TargetTag>;
using ObjectId = base::Id<struct ObjectTag>;  // of a simulated survey's truth
using TiePointId = base::Id<struct TiePointTag>;

}  // namespace cairn::survey
