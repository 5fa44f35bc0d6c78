// What the tracker and the consensus found, as records.
#pragma once

#include <cstddef>
#include <vector>

#include "localisation/boxes.hpp"
#include "localisation/consensus.hpp"
#include "localisation/locate.hpp"
#include "localisation/options.hpp"
#include "localisation/tracker.hpp"
#include "survey/target.hpp"

namespace cairn::localisation {

struct TargetRecord {
  survey::Target target;
  TargetEvidence evidence;
  Points points;  // none of a deregistered target
};

// mode paper: centre and covariance are those of the points.
[[nodiscard]] TargetRecord paper_record(const PreparedBoxes& prepared, const LiveTarget& live);

// mode robust: centre and covariance of the consensus, stages by its evidence; the filter is run again over the
// target's whole boxes for points, entropy, divergence and cylinder.
[[nodiscard]] TargetRecord robust_record(const PreparedBoxes& prepared, const PointsTracker& tracker,
                                         const Candidate& candidate, const LocateOptions& options);

// mode robust: boxes of a tracker's target of which the consensus took none.
[[nodiscard]] TargetRecord leftover_record(const PreparedBoxes& prepared, const PointsTracker& tracker,
                                           survey::TargetId id, const std::vector<std::size_t>& boxes,
                                           const LocateOptions& options);

}  // namespace cairn::localisation
