// Random numbers keyed by (seed, stage, record): adding a stage, a record or a thread
// shifts nothing else. Own generator and own distributions, so every platform draws the
// same numbers.
#pragma once

#include <cstdint>
#include <string_view>

namespace cairn::base {

// xoshiro256** (Blackman & Vigna 2018), seeded by SplitMix64 over the key. Not for cryptography.
class Random {
 public:
  Random(std::uint64_t seed, std::string_view stage, std::uint64_t record);

  // Uniform over all 64-bit integers.
  [[nodiscard]] std::uint64_t bits();
  // Uniform in [0, 1), 53 bits.
  [[nodiscard]] double uniform();
  // Uniform in [lo, hi).
  [[nodiscard]] double uniform(double lo, double hi);
  // Standard normal (Marsaglia's polar method).
  [[nodiscard]] double normal();
  // Uniform integer in [0, count), count >= 1, without modulo bias.
  [[nodiscard]] std::uint64_t below(std::uint64_t count);

 private:
  std::uint64_t state_[4];
  double spare_ = 0.0;
  bool has_spare_ = false;
};

// 64-bit FNV-1a: the stable hash of names used for keys.
[[nodiscard]] std::uint64_t stable_hash(std::string_view text);

}  // namespace cairn::base
