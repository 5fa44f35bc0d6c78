// Parallel loops and sums whose results do not depend on the number of threads.
#pragma once

#include <cstddef>
#include <functional>
#include <span>

namespace cairn::base {

// Calls body(begin, end) over consecutive pieces of at most `grain` items that cover [0, count).
// Pieces may run at once: write results by index only. The first exception is rethrown.
void parallel_for(std::size_t count, std::size_t grain,
                  const std::function<void(std::size_t begin, std::size_t end)>& body);

// Sum of values with a fixed tree of pieces of 4096: the same bits for any number of threads.
[[nodiscard]] double deterministic_sum(std::span<const double> values);

// Caps the worker threads for the life of the object; create one, in main. 0 = all cores.
class ThreadLimit {
 public:
  explicit ThreadLimit(int threads);
  ~ThreadLimit();
  ThreadLimit(const ThreadLimit&) = delete;
  ThreadLimit& operator=(const ThreadLimit&) = delete;
  [[nodiscard]] int threads() const noexcept { return threads_; }

 private:
  int threads_;
  void* control_;
};

}  // namespace cairn::base
