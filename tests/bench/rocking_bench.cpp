// Records a minute: a rock of two toes, and one that rolls over a hull, under records of 40 s at 200 samples a second.
#include <cmath>
#include <iostream>
#include <numbers>

#include "base/random.hpp"
#include "bench/cpu_clock.hpp"
#include "fragility/ground_motion.hpp"
#include "fragility/shake_suite.hpp"

int main() {
  using namespace cairn;
  std::vector<fragility::SuiteMotion> motions;
  for (std::uint64_t k = 0; k < 20; ++k) {
    fragility::SuiteMotion m;
    m.name = std::to_string(k);
    m.dt = 0.005;
    base::Random random(1, "rocking bench", k);
    double a = 0.0;
    for (int i = 0; i < 8000; ++i) {
      a = 0.98 * a + random.normal();
      // Builds up and dies away as an earthquake does.
      const double t = i / 8000.0;
      m.horizontal.push_back(a * std::sin(std::numbers::pi * t) * std::exp(-2.0 * t));
    }
    const auto measure = fragility::measures(m.horizontal, m.dt);
    for (double& x : m.horizontal) x *= fragility::kGravity / measure.pga_m_s2;
    m.pga = fragility::kGravity;
    m.pgv = measure.pgv_m_s * fragility::kGravity / measure.pga_m_s2;
    motions.push_back(std::move(m));
  }
  fragility::SuiteOptions options;
  options.eta_draws = 1;
  const std::vector<double> scales = {0.2, 0.4, 0.6, 0.8, 1.0};
  base::RunContext ctx;
  const double before = bench::cpu_seconds();
  const auto outcomes = fragility::run_suite([](double) { return fragility::rectangle_profile(0.25, 1.0); }, motions,
                                             scales, options, ctx);
  const double seconds = bench::cpu_seconds() - before;
  std::size_t rocked = 0, toppled = 0;
  for (const auto& o : outcomes) {
    rocked += o.rocked ? 1U : 0U;
    toppled += o.toppled ? 1U : 0U;
  }
  std::cout << outcomes.size() << " runs of 40 s, " << rocked << " rocked, " << toppled << " toppled: " << seconds
            << " CPU s, " << 60.0 * static_cast<double>(outcomes.size()) / seconds << " records a CPU minute\n";
}
