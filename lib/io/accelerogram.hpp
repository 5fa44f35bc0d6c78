// Records of ground acceleration, in the forms that agencies and laboratories give them out.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "base/options.hpp"
#include "survey/accelerogram.hpp"

namespace cairn::io {

struct RecordOptions {
  // For files that name no unit: "g", "m/s2" or "cm/s2" of acceleration. "none" = such files are refused.
  std::string unit = "none";
  // Column of the acceleration in a table of columns, by its header; "" = the only one there is beside the time.
  std::string column;

  void visit(base::OptionVisitor& visitor);
};

// All components of a file, in its order; m/s^2. The format is told by the content:
//   peer_at2        PEER NGA: four header lines, units in the third, NPTS and DT in the fourth, free body
//   smc             USGS SMC: 11 text lines, 48 integers, 50 reals, comments, values in cm/s^2
//   cosmos          COSMOS / CSMIP volume 2: every block "... acceleration pts ..., units=cm/sec2", V2 and V2c
//   velocity_table  shake robot: velocity in m/s; the acceleration is its difference quotient (note)
//   columns         time and acceleration, separated by blanks, tabs, commas or semicolons, with or without header;
//                   the unit from the header ("Acceleration [g]", "a_m_s2") or from options.unit
// Values that a fixed-width writer ran together ("1.2-3.4") are parted where a point shows that they are two; values
// beyond the count in the header are cut (note).
// Throws invalid_input with file and line: no unit, no step, a step that is not constant (beyond a tenth of it),
// fewer values than the header says, a count that the file cannot hold, a word that is no finite number.
[[nodiscard]] std::vector<survey::Accelerogram> read_accelerograms(const std::filesystem::path& path,
                                                                   const RecordOptions& options = {});

}  // namespace cairn::io
