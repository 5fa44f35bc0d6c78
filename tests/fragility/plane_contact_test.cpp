#include "fragility/plane_contact.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <iostream>

#include "base/angle.hpp"
#include "base/error.hpp"
#include "base/random.hpp"
#include "fragility/logistic.hpp"
#include "io/csv.hpp"
#include "io/obj.hpp"
#include "support/bodies.hpp"
#include "support/data.hpp"

namespace cairn::fragility {
namespace {

using geometry::Vec3;

TEST(PlaneContact, OfABlock) {
  const auto mesh = testing::block(1, 2, 3);
  const auto mass = geometry::mass_properties(mesh);
  const auto contact = plane_contact(mesh.vertices, mass);
  ASSERT_TRUE(contact);
  EXPECT_NEAR(contact->height, 1.5, 1e-12);
  // One triangle of the base bears; the plumb point lies on its diagonal: alpha 0 there, so the profile goes by the
  // hull.
  const auto profile = plane_profile(mesh.vertices, mass, 90.0);
  ASSERT_TRUE(profile);
  EXPECT_NEAR(base::rad_to_deg(profile->toes[1].alpha), 18.434949, 5.1e-7);
}

// Without noise and restitution fixed, the prediction of a block is 0 below its tipping acceleration and 1 far above.
TEST(PlaneContact, PulsesOnABlock) {
  const auto mesh = testing::block(0.3, 1, 1);
  const auto mass = geometry::mass_properties(mesh);
  PulseTestOptions options;
  options.contact_draws = 4;
  options.vertex_noise_m = 0.0;
  options.azimuth_deg = 90.0;
  base::RunContext ctx;
  const std::vector<std::array<double, 2>> tests = {{0.29, 0.5}, {3.0, 0.3}};
  const auto prediction = predict_pulse_tests(mesh, mass, tests, options, ctx);
  EXPECT_EQ(prediction.probability[0], 0.0);
  EXPECT_EQ(prediction.probability[1], 1.0);
  EXPECT_EQ(prediction.unstable_draws, 0U);
  EXPECT_NEAR(prediction.alpha_quantiles[2], std::atan(0.3), 1e-9);
}

// The specimen on a plane by geometry alone against its tests. How it stood is not published: docs/science/rocking.md
// declares what is taken. The outcomes may not be copied here: CAIRN_SHAKE_TABLE_DATA names the folder of
// sp1_outcomes.csv.
TEST(PlaneContact, ShakeTableTestsOfSp1) {
  const char* folder = std::getenv("CAIRN_SHAKE_TABLE_DATA");
  if (folder == nullptr) GTEST_SKIP() << "CAIRN_SHAKE_TABLE_DATA does not name the folder of sp1_outcomes.csv";
  const auto mesh = io::read_obj_mesh(testing::test_data("pbr_meshes/final_sp1.obj")).mesh;
  const auto mass = geometry::mass_properties(mesh);
  io::CsvReader csv(std::filesystem::path(folder) / "sp1_outcomes.csv");
  std::vector<std::array<double, 2>> tests;
  std::vector<ShakeOutcome> outcomes;
  while (csv.next()) {
    tests.push_back({csv.real(csv.column("pga_g")), csv.real(csv.column("pgv_over_pga_s"))});
    outcomes.push_back(
        {tests.back()[0], tests.back()[1], csv.integer(csv.column("sp1_overturned")) == 1, outcomes.size()});
  }
  ASSERT_EQ(outcomes.size(), 346U);
  base::RunContext ctx;
  const auto prediction = predict_pulse_tests(mesh, mass, tests, {}, ctx);
  std::size_t right = 0;
  for (std::size_t i = 0; i < tests.size(); ++i)
    right += (prediction.probability[i] >= 0.5) == outcomes[i].toppled ? 1U : 0U;
  const double accuracy = static_cast<double>(right) / 346.0;
  const double brier = brier_score(prediction.probability, outcomes);
  // Logistic in ln PGV, ten folds by test number.
  std::vector<double> validated(tests.size());
  for (std::size_t fold = 0; fold < 10; ++fold) {
    std::vector<ShakeOutcome> train;
    for (std::size_t i = 0; i < outcomes.size(); ++i)
      if (i % 10 != fold)
        train.push_back({outcomes[i].pga_g * outcomes[i].pgv_over_pga_s, 1.0, outcomes[i].toppled, i});
    const auto fit = fit_logistic(train, {false, false});
    ASSERT_TRUE(fit.fitted);
    for (std::size_t i = fold; i < outcomes.size(); i += 10)
      validated[i] = fit.probability(outcomes[i].pga_g * outcomes[i].pgv_over_pga_s, 1.0);
  }
  const double rival = brier_score(validated, outcomes);
  std::cout << "accuracy " << accuracy << ", Brier " << brier << ", logistic in ln PGV " << rival << ", azimuth "
            << prediction.azimuth_deg << ", alpha " << base::rad_to_deg(prediction.contact.alpha) << ", noise "
            << prediction.vertex_noise_m << ", unstable " << prediction.unstable_draws << ", toppling angle";
  for (const double a : prediction.alpha_quantiles) std::cout << ' ' << base::rad_to_deg(a);
  std::cout << "\n";
  EXPECT_GE(accuracy, 0.80);
  // The fit of all outcomes that the reference gives.
  const auto fit = fit_logistic(outcomes, {false, true});
  EXPECT_NEAR(fit.b[0], 18.6650, 6e-4);
  EXPECT_NEAR(fit.b[1], 4.80963, 6e-5);
  EXPECT_NEAR(fit.b[2], 3.98321, 6e-5);
}

}  // namespace
}  // namespace cairn::fragility
