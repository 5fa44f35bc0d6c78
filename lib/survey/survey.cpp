#include "survey/survey.hpp"

#include <algorithm>

namespace cairn::survey {
namespace {

template <typename Record, typename Id>
const Record* find_sorted(const std::vector<Record>& records, Id id) {
  const auto it = std::lower_bound(records.begin(), records.end(), id,
                                   [](const Record& record, Id wanted) { return record.id < wanted; });
  return it != records.end() && it->id == id ? &*it : nullptr;
}

}  // namespace

const Frame* Survey::frame(FrameId id) const {
  return find_sorted(frames, id);
}
const Detection* Survey::detection(DetectionId id) const {
  return find_sorted(detections, id);
}

const Camera* Survey::camera(CameraId id) const {
  for (const auto& camera : manifest.cameras)
    if (camera.id == id) return &camera;
  return nullptr;
}

const Source* Survey::source(std::string_view kind) const {
  for (const auto& source : manifest.sources)
    if (source.kind == kind) return &source;
  return nullptr;
}

}  // namespace cairn::survey
