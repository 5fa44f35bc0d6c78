#include <tbb/blocked_range.h>
#include <tbb/global_control.h>
#include <tbb/info.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <vector>

#include "base/parallel.hpp"

namespace cairn::base {

void parallel_for(std::size_t count, std::size_t grain, const std::function<void(std::size_t, std::size_t)>& body) {
  if (count == 0) return;
  grain = std::max<std::size_t>(grain, 1);
  if (count <= grain) {
    body(0, count);
    return;
  }
  const std::size_t pieces = (count + grain - 1) / grain;
  // Pieces are cut here, not by the partitioner, so their bounds never follow the thread count.
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, pieces, 1), [&](const tbb::blocked_range<std::size_t>& range) {
    for (std::size_t p = range.begin(); p != range.end(); ++p) body(p * grain, std::min(count, (p + 1) * grain));
  });
}

double deterministic_sum(std::span<const double> values) {
  constexpr std::size_t kGrain = 4096;
  std::vector<double> partial((values.size() + kGrain - 1) / kGrain, 0.0);
  parallel_for(values.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    double sum = 0.0;
    for (std::size_t i = begin; i < end; ++i) sum += values[i];
    partial[begin / kGrain] = sum;
  });
  double total = 0.0;
  for (const double p : partial) total += p;
  return total;
}

ThreadLimit::ThreadLimit(int threads)
    : threads_(threads > 0 ? threads : tbb::info::default_concurrency()),
      control_(
          new tbb::global_control(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads_))) {}

ThreadLimit::~ThreadLimit() {
  delete static_cast<tbb::global_control*>(control_);
}

}  // namespace cairn::base
