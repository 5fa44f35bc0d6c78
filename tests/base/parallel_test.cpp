#include "base/parallel.hpp"

#include <gtest/gtest.h>

#include <stdexcept>
#include <vector>

#include "base/random.hpp"

namespace cairn::base {
namespace {

TEST(ParallelFor, VisitsEachIndexOnce) {
  for (const std::size_t count : {0U, 1U, 7U, 1000U, 100001U}) {
    std::vector<int> visits(count, 0);
    parallel_for(count, 64, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) ++visits[i];
    });
    for (const int v : visits) ASSERT_EQ(v, 1);
  }
}

TEST(ParallelFor, RethrowsTheBodysException) {
  EXPECT_THROW(parallel_for(1000, 10,
                            [](std::size_t begin, std::size_t) {
                              if (begin == 500) throw std::runtime_error("x");
                            }),
               std::runtime_error);
}

TEST(DeterministicSum, SameBitsForAnyThreadCount) {
  Random random(3, "sum", 0);
  std::vector<double> values(300000);
  for (auto& v : values) v = random.uniform(-1e8, 1e8);
  double reference = 0.0;
  for (const int threads : {1, 2, 4, 8}) {
    const ThreadLimit limit(threads);
    const double sum = deterministic_sum(values);
    if (threads == 1) reference = sum;
    EXPECT_EQ(sum, reference) << threads;
  }
}

}  // namespace
}  // namespace cairn::base
