#include "fragility/published_model.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "io/fragility_model.hpp"
#include "support/data.hpp"

namespace cairn::fragility {
namespace {

using ::testing::HasSubstr;

std::string refusal(const std::function<void()>& work) {
  try {
    work();
  } catch (const base::Error& e) {
    return e.what();
  }
  return "";
}

TEST(PublishedModel, ShippedModelsHaveNoCoefficientsAndRefuse) {
  for (const std::string name : {"purvance2008", "dimitrakopoulos2015"}) {
    const auto model = io::read_fragility_model(testing::sample("fragility_models/" + name + ".json"));
    EXPECT_TRUE(model.coefficients.empty());
    EXPECT_THAT(refusal([&] { (void)published_probability(model, 0.3, 1.0, 2.0, 0.3, 0.1); }),
                HasSubstr("model " + name + ": coefficients not supplied"));
  }
}

TEST(PublishedModel, FormsAndRanges) {
  survey::FragilityModel model;
  model.name = "made up";
  model.form = "logistic_ln_pga_ln_ratio";
  model.coefficients = {{"b0", 18.665}, {"b1", 4.80963}, {"b2", 3.98321}};
  model.valid["alpha_rad"] = {0.1, 0.5};
  // The fit of the shake table: half of the specimens at 0.139 g and 0.10 s.
  EXPECT_NEAR(published_probability(model, 0.3, 1.0, 2.0, 0.139, 0.10), 0.5, 0.01);
  EXPECT_THAT(refusal([&] { (void)published_probability(model, 0.6, 1.0, 2.0, 0.2, 0.1); }), HasSubstr("alpha_rad"));
  model.coefficients.erase("b2");
  EXPECT_THAT(refusal([&] { (void)published_probability(model, 0.3, 1.0, 2.0, 0.2, 0.1); }), HasSubstr("b2"));
  model.form = "lognormal_p_pgv";
  model.coefficients = {{"median", 2.0}, {"beta", 0.5}};
  // p PGV / (g tan alpha) = 2: half.
  const double alpha = 0.3, pga = 2.0 * std::tan(alpha) / (2.0 * 0.1);
  EXPECT_NEAR(published_probability(model, alpha, 1.0, 2.0, pga, 0.1), 0.5, 1e-12);
  model.form = "guess";
  EXPECT_THAT(refusal([&] { (void)published_probability(model, 0.3, 1.0, 2.0, 0.2, 0.1); }), HasSubstr("form"));
}

TEST(PublishedModel, FilesAreChecked) {
  testing::TempFolder folder;
  const std::string rest = R"("reference": "r", "doi": "", "form": "f", "im": ["PGA"], "valid": {)";
  const auto read = [&](const std::string& text) {
    base::write_file(folder / "m.json", text);
    return refusal([&] { (void)io::read_fragility_model(folder / "m.json"); });
  };
  EXPECT_EQ(read(R"({"name": "n", )" + rest + R"(}, "coefficients": {}, "entered_by": "", "checked_against": ""})"),
            "");
  EXPECT_THAT(
      read(R"({"name": "n", )" + rest + R"(}, "coefficients": {"b0": 1}, "entered_by": "", "checked_against": ""})"),
      HasSubstr("entered_by"));
  EXPECT_THAT(read(R"({"name": "n", )" + rest +
                   R"("r_m": [2, 1]}, "coefficients": {}, "entered_by": "", "checked_against": ""})"),
              HasSubstr("range of validity"));
  EXPECT_THAT(read(R"({"name": "n", )" + rest +
                   R"(}, "coefficients": {}, "entered_by": "", "checked_against": "", "sigm": 1})"),
              HasSubstr("sigm"));
  EXPECT_THAT(read(R"({"name": "n"})"), HasSubstr("reference"));
}

}  // namespace
}  // namespace cairn::fragility
