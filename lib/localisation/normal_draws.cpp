#include "localisation/normal_draws.hpp"

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace cairn::localisation {
namespace {

constexpr std::size_t kLayers = 256;
constexpr double kTailStart = 3.6541528853610088;  // R for 256 layers (Doornik 2005)
constexpr double kLayerArea = 0.00492867323399;    // V: area of each layer

constexpr double kUnit = 0x1.0p-23;  // of the signed 24-bit fractions below

// Layer i spans |x| < x[i]; x[0] is the base layer's pseudo-width, x[256] = 0. f[i] = exp(-x^2/2).
// width[i] makes x of a fraction; fractions below inner[i] lie under the curve whatever their height.
struct Tables {
  std::array<double, kLayers + 1> x{}, f{};
  std::array<double, kLayers> width{};
  std::array<std::int32_t, kLayers> inner{};
  Tables() {
    double density = std::exp(-0.5 * kTailStart * kTailStart);
    x[0] = kLayerArea / density;
    x[1] = kTailStart;
    for (std::size_t i = 2; i < kLayers; ++i) {
      x[i] = std::sqrt(-2.0 * std::log(kLayerArea / x[i - 1] + density));
      density = std::exp(-0.5 * x[i] * x[i]);
    }
    x[kLayers] = 0.0;
    for (std::size_t i = 0; i <= kLayers; ++i) f[i] = std::exp(-0.5 * x[i] * x[i]);
    for (std::size_t i = 0; i < kLayers; ++i) {
      width[i] = x[i] * kUnit;
      inner[i] = static_cast<std::int32_t>(x[i + 1] / x[i] / kUnit) - 1;
    }
  }
};

// xoshiro256** in line, started from the caller's generator: a call for each number would cost a fifth of the time.
class Stream {
 public:
  explicit Stream(base::Random& random) {
    for (auto& word : state_) word = random.bits();
    state_[0] |= 1;  // never all zero
  }
  std::uint64_t bits() {
    const std::uint64_t product = state_[1] * 5;
    const std::uint64_t result = ((product << 7) | (product >> 57)) * 9, t = state_[1] << 17;
    state_[2] ^= state_[0];
    state_[3] ^= state_[1];
    state_[1] ^= state_[2];
    state_[0] ^= state_[3];
    state_[2] ^= t;
    state_[3] = (state_[3] << 45) | (state_[3] >> 19);
    return result;
  }
  double uniform() { return static_cast<double>(bits() >> 11) * 0x1.0p-53; }

 private:
  std::uint64_t state_[4];
};

double tail(Stream& random, bool negative) {
  double x = 0.0, y = 0.0;
  do {
    x = std::log(1.0 - random.uniform()) / kTailStart;  // 1 - u: never log(0)
    y = std::log(1.0 - random.uniform());
  } while (-2.0 * y < x * x);
  return negative ? x - kTailStart : kTailStart - x;
}

// From 32 random bits: 8 choose the layer, 24 the signed fraction of its width. More bits are drawn where the fraction
// lies outside the part of the layer that is under the curve everywhere (one draw in a hundred).
inline double normal_from(std::uint32_t bits, const Tables& tables, Stream& random) {
  for (;;) {
    const std::size_t layer = bits & (kLayers - 1);
    const std::int32_t fraction = static_cast<std::int32_t>(bits) >> 8;
    const double x = (static_cast<double>(fraction) + 0.5) * tables.width[layer];
    if (std::abs(fraction) < tables.inner[layer]) return x;
    if (layer == 0) {
      if (std::abs(x) < kTailStart) return x;
      return tail(random, fraction < 0);
    }
    const double f = tables.f[layer] + random.uniform() * (tables.f[layer + 1] - tables.f[layer]);
    if (f < std::exp(-0.5 * x * x)) return x;
    bits = static_cast<std::uint32_t>(random.bits() >> 32);
  }
}

}  // namespace

void fill_normal(std::span<double> out, base::Random& source) {
  static const Tables tables;
  Stream random(source);
  std::size_t i = 0;
  for (; i + 1 < out.size(); i += 2) {
    const std::uint64_t bits = random.bits();
    out[i] = normal_from(static_cast<std::uint32_t>(bits), tables, random);
    out[i + 1] = normal_from(static_cast<std::uint32_t>(bits >> 32), tables, random);
  }
  if (i < out.size()) out[i] = normal_from(static_cast<std::uint32_t>(random.bits() >> 32), tables, random);
}

}  // namespace cairn::localisation
