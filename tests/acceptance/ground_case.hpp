// Paper B's demonstrations, one run after the other, as lines of JSON and as tables.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "base/run_context.hpp"
#include "io/json.hpp"
#include "simulation/drive_rehearsal.hpp"

namespace cairn::acceptance {

// What is varied: aerial (all that the aircraft sends is used), no_map (obstacles are not), outage_10 (aerial, with
// outages of 10 s in every 30 s), outage_20.
[[nodiscard]] const std::vector<std::string>& ground_variants();

// One run. Throws invalid_argument for an unknown variant.
[[nodiscard]] io::Json ground_case(const simulation::DriveRehearsal& rehearsal, const std::string& scene,
                                   const std::string& variant, std::uint64_t seed, base::RunContext& ctx);

// Markdown, one row a scene and variant: arrivals (by the vehicle's reckoning, and truly within 2 m) and runs without
// contact with 95 % Wilson intervals; mean way with its 95 % bootstrap interval; the mean over seeds of 1 -
// way(variant) / way(no_map) likewise; least clearance, pose errors, update periods. Runs that did not arrive are left
// out of the ways.
[[nodiscard]] std::string ground_table(const std::vector<io::Json>& lines);

// Mean shortening of `variant` against no_map over the seeds that have both and arrived in both.
struct Shortening {
  std::size_t seeds = 0;
  double mean = 0.0, low = 0.0, high = 0.0;
};
[[nodiscard]] Shortening shortening(const std::vector<io::Json>& lines, const std::string& scene,
                                    const std::string& variant);

}  // namespace cairn::acceptance
