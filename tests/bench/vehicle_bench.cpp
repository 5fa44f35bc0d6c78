// A drive of 20 minutes through the pose filter: 60 000 samples, the packets of the paper's link, states at 25 Hz.
#include <iostream>

#include "bench/cpu_clock.hpp"
#include "ground/pose_run.hpp"
#include "support/ground_drive.hpp"

int main() {
  using namespace cairn;
  for (const char* link : {"football", "park"}) {
    testing::DriveOptions options;
    options.link.profile = link;
    const auto drive = testing::make_drive(options, 1);
    const double before = bench::cpu_seconds();
    const auto run = ground::run_pose_filter(drive.log, drive.packets, {}, 25.0, base::RunContext());
    const double seconds = bench::cpu_seconds() - before;
    std::cout << link << ": " << drive.log.size() << " samples, " << drive.packets.size() << " packets, "
              << run.filtered.size() << " states: " << seconds << " CPU s\n";
  }
}
