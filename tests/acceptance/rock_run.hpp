// One simulated rock through segment, surface and fragility, scored against its truth.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "base/run_context.hpp"
#include "io/json.hpp"
#include "support/rock_scan.hpp"

namespace cairn::acceptance {

struct RockRunOptions {
  testing::RockScanOptions scan;
  bool guided = true;          // a located target with errors of its own tells where the rock is; else nothing does
  bool true_labels = false;    // surface and fragility get the true labels and rim: what the later steps cost alone
  std::filesystem::path keep;  // folder that keeps the files of each run; "" = none
};

// {"kind": "rock", "seed", "sampling", "family", "hiding", "hidden_share", "points", "spacing_m", "cpu_s": {segment,
// surface, fragility}, "failed": "" or where and why, "scores": summary of evaluate segmentation}.
[[nodiscard]] io::Json run_rock(std::uint64_t seed, const RockRunOptions& options, base::RunContext& ctx);

// A cloud of many rocks, found without targets: {"kind": "scene", "seed", "family", "points", "rocks", "cpu_s",
// "failed", "scores"}.
[[nodiscard]] io::Json run_scene(std::uint64_t seed, const testing::RockSceneOptions& options,
                                 const std::filesystem::path& keep, base::RunContext& ctx);

// A labelled cloud with its truth.json, its rocks' cylinders as targets (without truth unguided), through the same
// chain: {"kind": "cloud", "seed": 0, "family": "",
// "cpu_s", "failed", "scores"}. Its own labels are the truth.
[[nodiscard]] io::Json run_cloud(const std::filesystem::path& cloud, const std::filesystem::path& truth,
                                 const std::filesystem::path& keep, base::RunContext& ctx);

}  // namespace cairn::acceptance
