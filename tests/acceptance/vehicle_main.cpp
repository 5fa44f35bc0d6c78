// Simulated drives of 20 minutes through the pose filter, many seeds: the figures of docs/accuracy.md.
//   build/release/tests/acceptance_vehicle --seeds 100
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <string>
#include <vector>

#include "ground/pose_run.hpp"
#include "ground/pose_score.hpp"
#include "support/ground_drive.hpp"

namespace {

using namespace cairn;
using cairn::testing::DriveOptions;

struct Case {
  std::string name;
  DriveOptions drive;
  std::string mode = "robust";
};

struct Pool {
  double squares = 0.0, worst = 0.0, nees = 0.0, p95 = 0.0, log = 0.0, dead = 0.0;
  double growth = 0.0, drift = 0.0, way = 0.0;
  std::size_t drives = 0, dropouts = 0, false_seen = 0, false_taken = 0, true_seen = 0, true_refused = 0;
};

void add(Pool& pool, const Case& c, std::uint64_t seed) {
  const auto drive = cairn::testing::make_drive(c.drive, seed);
  ground::PoseFilterOptions options;
  options.mode = c.mode;
  const auto run = ground::run_pose_filter(drive.log, drive.packets, options, 25.0, base::RunContext());
  const auto errors = ground::track_errors(run.filtered, drive.truth);
  pool.squares += errors.rms_m * errors.rms_m;
  pool.worst = std::max(pool.worst, errors.rms_m);
  pool.p95 += errors.p95_m;
  pool.nees += errors.nees;
  pool.log += std::pow(ground::track_errors(run.inertial, drive.truth).rms_m, 2);
  pool.dead += std::pow(ground::track_errors(run.dead_reckoned, drive.truth).rms_m, 2);
  std::vector<std::int64_t> arrivals;
  for (const auto& p : drive.packets) arrivals.push_back(p.arrival_time_ns);
  constexpr double kDropout_s = 3.0;
  const auto dropouts = ground::dropout_errors(run.filtered, drive.truth, arrivals, kDropout_s);
  pool.dropouts += dropouts.count;
  pool.way += dropouts.distance_m;
  pool.growth += dropouts.growth_percent * dropouts.distance_m;
  pool.drift += dropouts.drift_percent * dropouts.drift_percent * static_cast<double>(dropouts.count);
  for (const auto& u : run.updates) {
    if (drive.has_false[u.packet] && u.candidate == 0) {
      ++pool.false_seen;
      pool.false_taken += u.accepted ? 1U : 0U;
    } else if (u.reason != "after_log") {
      ++pool.true_seen;
      pool.true_refused += u.accepted ? 0U : 1U;
    }
  }
  ++pool.drives;
}

std::vector<Case> cases() {
  std::vector<Case> all;
  for (const char* mode : {"robust", "paper"})
    for (const char* link : {"football", "park", "ideal"}) {
      Case c{std::string(link), {}, mode};
      c.drive.link.profile = link;
      all.push_back(c);
    }
  for (const double outage_s : {3.1, 10.0}) {
    Case c{"ideal, outages", {}};
    c.name += outage_s < 5.0 ? " of 3.1 s" : " of 10 s";
    c.drive.link.profile = "ideal";
    c.drive.link.outage_every_s = outage_s < 5.0 ? 20.0 : 60.0;
    c.drive.link.outage_s = outage_s;
    all.push_back(c);
  }
  for (const double time_s : {5.0, 1000.0}) {
    Case c{"football, errors drift in " + std::string(time_s < 10.0 ? "5" : "1000") + " s", {}};
    c.drive.errors.bias_time_s = c.drive.errors.heading_time_s = time_s;
    all.push_back(c);
  }
  Case fast{"football, 2 m/s", {}};
  fast.drive.speed_m_s = 2.0;
  all.push_back(fast);
  Case resting{"football, at rest", {}};
  resting.drive.resting = true;
  all.push_back(resting);
  return all;
}

}  // namespace

int main(int argc, char** argv) {
  std::uint64_t first = 1, seeds = 20;
  for (int i = 1; i + 1 < argc; i += 2) {
    const std::string name = argv[i];
    if (name == "--seeds") seeds = std::strtoull(argv[i + 1], nullptr, 10);
    if (name == "--first") first = std::strtoull(argv[i + 1], nullptr, 10);
  }
  std::printf(
      "| link | mode | drives | RMS, pooled / worst drive | 95 %% | NEES | log alone | summed | false taken | true "
      "refused "
      "| dropouts | growth | drift |\n|---|---|---|---|---|---|---|---|---|---|---|---|---|\n");
  bool good = true;
  for (const auto& c : cases()) {
    Pool pool;
    for (std::uint64_t seed = first; seed < first + seeds; ++seed) add(pool, c, seed);
    if (pool.drives == 0) continue;
    const double n = static_cast<double>(pool.drives);
    const double rms = std::sqrt(pool.squares / n);
    std::printf("| %s | %s | %zu | %.3f / %.3f m | %.2f m | %.2f | %.2f m | %.1f m | %zu of %zu | %zu of %zu | %zu | ",
                c.name.c_str(), c.mode.c_str(), pool.drives, rms, pool.worst, pool.p95 / n, pool.nees / n,
                std::sqrt(pool.log / n), std::sqrt(pool.dead / n), pool.false_taken, pool.false_seen, pool.true_refused,
                pool.true_seen, pool.dropouts);
    if (pool.dropouts > 0)
      std::printf("%.2f %% | %.2f %% |\n", pool.growth / pool.way,
                  std::sqrt(pool.drift / static_cast<double>(pool.dropouts)));
    else std::printf("| |\n");
    std::fflush(stdout);
    constexpr double kAsked_m = 0.25;
    if (c.mode == "robust" && c.name.find("10 s") == std::string::npos) good = good && rms <= kAsked_m;
  }
  std::printf("\nCPU %.1f s\n", static_cast<double>(std::clock()) / CLOCKS_PER_SEC);
  return good ? 0 : 1;
}
