// One component of ground acceleration at a constant step.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace cairn::survey {

struct Accelerogram {
  std::string name;       // of the file without its extension, with the component where a file has several
  std::string event;      // as the header says it; may be empty
  std::string station;    // likewise
  std::string component;  // likewise: "090", "UP", "X"
  // Direction of positive horizontal motion, clockwise from north; empty = not known.
  std::optional<double> azimuth_deg;
  bool vertical = false;             // positive upwards
  double dt_s = 0.0;                 // > 0; the same between all samples
  std::vector<double> acceleration;  // m/s^2, at times 0, dt, 2 dt, ..; finite, at least two
  std::string format;                // "peer_at2", "smc", "cosmos", "velocity_table", "columns"
  std::vector<std::string> notes;    // what the reader had to do or to assume, sentences
};

}  // namespace cairn::survey
