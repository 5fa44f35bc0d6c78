// A record that a stage did not use, and why. Rejects are returned beside the results,
// never dropped: every count in a summary is results + rejects.
#pragma once

#include <string>

namespace cairn::base {

struct Reject {
  std::string record;   // what was rejected: "detection 17", "target 4", "frame DJI_0030"
  std::string reason;   // reason code, snake_case, stable: "too_few_points"
  std::string message;  // one sentence for people, with the value found and the value needed

  friend bool operator==(const Reject&, const Reject&) = default;
};

}  // namespace cairn::base
