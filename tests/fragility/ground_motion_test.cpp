#include "fragility/ground_motion.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numbers>

#include "base/error.hpp"
#include "base/random.hpp"
#include "fragility/tipping.hpp"
#include "io/accelerogram.hpp"
#include "io/csv.hpp"
#include "support/data.hpp"

namespace cairn::fragility {
namespace {

using cairn::testing::test_data;

TEST(GroundMotion, OneCosineHasTheMeasuresItIsMadeFor) {
  const auto pulse = one_cosine(3.0, 0.2, 4000);
  const auto m = measures(pulse.acceleration, pulse.dt);
  EXPECT_DOUBLE_EQ(m.pga_m_s2, 3.0);
  EXPECT_NEAR(m.pgv_m_s, 0.6, 1e-6);
  // A = PGA / (4 pi^2 F^2), displacement 2 A at half the period.
  EXPECT_NEAR(m.pgd_m, 2.0 * 3.0 * 0.04, 1e-6);
  EXPECT_NEAR(m.final_velocity_m_s, 0.0, 1e-12);
  EXPECT_NEAR(m.duration_s, 2.0 * std::numbers::pi * 0.2, 1e-12);
}

TEST(GroundMotion, MeasuresOfARamp) {
  const std::vector<double> ramp = {0.0, 1.0, 2.0};
  const auto m = measures(ramp, 0.5);
  EXPECT_DOUBLE_EQ(m.pgv_m_s, 1.0);
  EXPECT_DOUBLE_EQ(m.pgd_m, 0.0625 + 0.3125);
  EXPECT_THROW((void)measures(std::vector<double>{1.0}, 0.5), base::Error);
}

// An oscillator under constant acceleration: u = a/w^2 (1 - cos wt), twice the static displacement undamped.
TEST(GroundMotion, SpectrumOfAStep) {
  const std::vector<double> step(2001, 2.0);
  const auto s = spectral_ordinate(step, 0.005, 1.0, 0.0);
  EXPECT_NEAR(s.pseudo_acceleration, 4.0, 1e-9);
  EXPECT_NEAR(s.absolute_acceleration, 4.0, 1e-9);
  // Damped: overshoot exp(-pi z / sqrt(1 - z^2)).
  const double z = 0.05;
  const auto d = spectral_ordinate(step, 0.005, 1.0, z);
  EXPECT_NEAR(d.pseudo_acceleration, 2.0 * (1.0 + std::exp(-std::numbers::pi * z / std::sqrt(1 - z * z))), 2e-4);
}

// Resonance under a sine for many cycles tends to 1 / (2 z).
TEST(GroundMotion, SpectrumAtResonance) {
  std::vector<double> sine(20001);
  for (std::size_t i = 0; i < sine.size(); ++i)
    sine[i] = std::sin(2.0 * std::numbers::pi * static_cast<double>(i) * 0.005);
  EXPECT_NEAR(spectral_ordinate(sine, 0.005, 1.0, 0.05).pseudo_acceleration, 10.0, 0.01);
}

// Nigam-Jennings against a brute-force Runge-Kutta of the same piecewise linear record.
TEST(GroundMotion, SpectrumAgainstRungeKutta) {
  base::Random random(2, "spectrum", 0);
  std::vector<double> a(300);
  for (auto& x : a) x = random.normal();
  const double dt = 0.02, z = 0.05;
  for (const double period : {0.1, 0.7, 3.0}) {
    const double w = 2.0 * std::numbers::pi / period;
    double u = 0.0, v = 0.0, peak = 0.0;
    const int fine = 400;
    const double h = dt / fine;
    for (std::size_t i = 0; i + 1 < a.size(); ++i)
      for (int k = 0; k < fine; ++k) {
        const auto f = [&](double t, double uu, double vv) {
          return -(a[i] + (a[i + 1] - a[i]) * t / dt) - 2.0 * z * w * vv - w * w * uu;
        };
        const double t = k * h;
        const double k1u = v, k1v = f(t, u, v);
        const double k2u = v + 0.5 * h * k1v, k2v = f(t + 0.5 * h, u + 0.5 * h * k1u, v + 0.5 * h * k1v);
        const double k3u = v + 0.5 * h * k2v, k3v = f(t + 0.5 * h, u + 0.5 * h * k2u, v + 0.5 * h * k2v);
        const double k4u = v + h * k3v, k4v = f(t + h, u + h * k3u, v + h * k3v);
        u += h / 6.0 * (k1u + 2 * k2u + 2 * k3u + k4u);
        v += h / 6.0 * (k1v + 2 * k2v + 2 * k3v + k4v);
        peak = std::max(peak, std::abs(u));
      }
    // The peak is looked for at 20 samples a period or more: 1 - cos(pi / 20) = 1.2 % at worst.
    const auto s = spectral_ordinate(a, dt, period, z);
    EXPECT_NEAR(s.displacement, peak, 0.0125 * peak) << period;
    EXPECT_LE(s.displacement, peak * (1.0 + 1e-6)) << period;
  }
}

// The record and spectrum that come with eqsig (MIT).
TEST(GroundMotion, SpectrumOfTheEqsigRecord) {
  const auto record = io::read_accelerograms(test_data("accelerograms/test_motion_avd.csv")).at(0);
  const auto m = measures(record.acceleration, record.dt_s);
  io::CsvReader motion(test_data("accelerograms/test_motion_avd.csv"));
  double pgv = 0.0, pgd = 0.0;
  while (motion.next()) {
    pgv = std::max(pgv, std::abs(motion.real(motion.column("Velocity [m/s]"))));
    pgd = std::max(pgd, std::abs(motion.real(motion.column("Displacement [m]"))));
  }
  constexpr double kPrinted = 1e-3;  // relative: the file's velocity is printed to six digits from g = 9.81
  EXPECT_NEAR(m.pgv_m_s, pgv, kPrinted * pgv);
  EXPECT_NEAR(m.pgd_m, pgd, 2e-3 * pgd);
  io::CsvReader truth(test_data("accelerograms/test_motion_true_spectra_acc.csv"));
  std::vector<double> errors;
  double worst_above = 0.0;
  while (truth.next()) {
    const double period = truth.real(0), expected = truth.real(1) * kGravity;
    const auto s = spectral_ordinate(record.acceleration, record.dt_s, period);
    errors.push_back(std::abs(s.pseudo_acceleration - expected) / expected);
    if (period >= 0.1) worst_above = std::max(worst_above, errors.back());
  }
  ASSERT_GT(errors.size(), 100U);
  std::sort(errors.begin(), errors.end());
  // The other program fills in between samples of 0.01 s its own way: it shows where a period holds few of them.
  EXPECT_LT(errors[errors.size() / 2], 0.003);
  EXPECT_LT(worst_above, 0.022);
  EXPECT_LT(errors.back(), 0.051);
}

TEST(GroundMotion, RotD50OfAPolarisedPair) {
  // Both components the same: the peak over direction is sqrt(2) |cos|, its median sqrt(2) cos(45 deg) = 1.
  const std::vector<double> a = {0.0, 1.0, -0.5};
  EXPECT_NEAR(rotd50(a, a, 0.01, 0.0), 1.0, 0.02);
}

// Real PEER records, which may not be copied here: CAIRN_RECORD_DATA names the folder that holds them.
TEST(GroundMotion, PeerRecords) {
  const char* folder = std::getenv("CAIRN_RECORD_DATA");
  if (folder == nullptr)
    GTEST_SKIP() << "CAIRN_RECORD_DATA does not name a folder with accelerograms and ground_motion_tab";
  const std::filesystem::path root = folder;
  const auto first = io::read_accelerograms(root / "accelerograms/RSN8883_14383980_13849090.AT2").at(0);
  const auto second = io::read_accelerograms(root / "accelerograms/RSN8883_14383980_13849360.AT2").at(0);
  EXPECT_EQ(first.acceleration.size(), 16396U);
  EXPECT_NEAR(measures(first.acceleration, first.dt_s).pga_m_s2 / kGravity, 0.095678815, 1e-9);
  EXPECT_NEAR(measures(second.acceleration, second.dt_s).pga_m_s2 / kGravity, 0.15980313, 1e-9);
  // RotD50 by an independent program (matrix exponential, peaks at the samples).
  EXPECT_NEAR(rotd50(first.acceleration, second.acceleration, first.dt_s, 0.0) / kGravity, 0.128831, 5e-4);
  EXPECT_NEAR(rotd50(first.acceleration, second.acceleration, first.dt_s, 1.0) / kGravity, 0.094044, 5e-4);
  EXPECT_NEAR(rotd50(first.acceleration, second.acceleration, first.dt_s, 2.0) / kGravity, 0.026361, 2e-4);
  const auto smc = io::read_accelerograms(root / "accelerograms/A-CAT090.AT2.smc").at(0);
  EXPECT_NEAR(measures(smc.acceleration, smc.dt_s).pga_m_s2, 0.4136, 1e-4);  // "pk mtn = 4.136E+1" cm/s^2
  // Velocity tables: PGV, PGA and their ratio as computed from the files by differences.
  const struct {
    const char* file;
    double pgv, pga_g, ratio;
  } tables[] = {{"ChiChi_-_PGVA_0.63681_TCU063N_Earthquake-1g.tab", 6.2450, 0.9995, 0.6372},
                {"Landers_-_PGVA_-_0.3496_FLO290_Earthquake-1g.tab", 3.4284, 0.9990, 0.3499},
                {"Parkfield_-_PGVA_0.10453_C02090_Earthquake-1g.tab", 1.0251, 0.9962, 0.1049},
                {"sinusoidal_motion_pga_0.25_pgva_0.2.tab", 0.490346, 0.25, 0.2}};
  for (const auto& t : tables) {
    const auto r = io::read_accelerograms(root / "ground_motion_tab" / t.file).at(0);
    const auto m = measures(r.acceleration, r.dt_s);
    EXPECT_NEAR(m.pga_m_s2 / kGravity, t.pga_g, 6e-5) << t.file;
    EXPECT_NEAR(m.pgv_m_s, t.pgv, 2e-3 * t.pgv) << t.file;  // velocities stand half a step beside the file's
    EXPECT_NEAR(m.pgv_m_s / m.pga_m_s2, t.ratio, 2e-3 * t.ratio) << t.file;
  }
}

}  // namespace
}  // namespace cairn::fragility
