#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "base/atomic_file.hpp"
#include "base/number_text.hpp"
#include "io/json.hpp"
#include "io/ply.hpp"
#include "support/bodies.hpp"
#include "support/data.hpp"
#include "support/run_program.hpp"

namespace {

namespace fs = std::filesystem;
using cairn::testing::cairn;
using cairn::testing::TempFolder;
using ::testing::HasSubstr;

class Shake : public ::testing::Test {
 protected:
  TempFolder folder_;
  std::string mesh_ = (folder_ / "block.ply").string(), out_ = (folder_ / "out").string();
  void SetUp() override { ::cairn::io::write_ply(mesh_, ::cairn::testing::block(0.4, 1, 1.2)); }

  // A decaying sine of 1 g at `hertz`, as a made-up AT2 file.
  [[nodiscard]] std::string record(const std::string& name, double hertz) const {
    std::string text =
        "MADE UP FOR A TEST\nDecaying sine, 1/1/2000, Nowhere, 090\nACCELERATION TIME SERIES IN UNITS OF G\n";
    const int n = 800;
    text += "NPTS=  " + std::to_string(n) + ", DT=   .0100 SEC\n";
    for (int i = 0; i < n; ++i) {
      const double t = 0.01 * i;
      text += " " + ::cairn::base::to_fixed(std::exp(-0.5 * t) * std::sin(2.0 * std::numbers::pi * hertz * t), 7) +
              (i % 5 == 4 ? "\n" : "");
    }
    ::cairn::base::write_file(folder_ / name, text);
    return (folder_ / name).string();
  }
  [[nodiscard]] ::cairn::io::Json run(std::vector<std::string> arguments) const {
    const auto result = cairn(arguments);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return ::cairn::io::parse_json(result.out, "stdout");
  }
};

TEST_F(Shake, RecordsAndScalesToAFragilityCurve) {
  const auto summary = run({"fragility",
                            mesh_,
                            "--shake",
                            record("a.AT2", 0.8),
                            record("b.AT2", 2.0),
                            record("c.AT2", 4.0),
                            "--scale",
                            "0.1:2:0.1",
                            "--shake-azimuth-step-deg",
                            "90",
                            "--eta-draws",
                            "2",
                            "--bootstrap-draws",
                            "40",
                            "--map-pga-steps",
                            "12",
                            "--map-ratio-steps",
                            "10",
                            "-o",
                            out_,
                            "--json"});
  ASSERT_EQ(summary.at("records").size(), 3U);
  const auto& first = summary.at("records").as_array()[0];
  EXPECT_EQ(first.at("format").as_string(), "peer_at2");
  EXPECT_NEAR(first.at("pga_g").as_real(), 0.86, 0.02);
  EXPECT_EQ(summary.at("scales").size(), 20U);
  const auto& rock = summary.at("rocks").as_array().at(0);
  EXPECT_EQ(rock.at("runs").as_integer(), 3 * 20 * 4 * 2);
  EXPECT_EQ(rock.at("grade").as_string(), "screening");  // the base is assumed
  EXPECT_NEAR(rock.at("alpha_min_deg").as_real(), 18.434949, 1e-5);
  const auto& fit = rock.at("logistic");
  EXPECT_TRUE(fit.at("fitted").as_bool());
  EXPECT_TRUE(fit.at("with_ratio").as_bool());
  EXPECT_GT(fit.at("b").as_array()[1].as_real(), 0.0);
  EXPECT_GT(fit.at("toppled").as_integer(), 0);
  EXPECT_EQ(rock.at("by_eta").size(), 2U);
  for (const std::string file : {"block_shake.json", "block_outcomes.csv", "block_curve.csv", "block_fragility.svg",
                                 "block_overturning.svg", "block_overturning.csv", "run.json"})
    EXPECT_TRUE(fs::exists(fs::path(out_) / file)) << file;
  const auto svg = ::cairn::base::read_file(fs::path(out_) / "block_fragility.svg");
  EXPECT_THAT(svg, HasSubstr("grade screening"));
  EXPECT_THAT(svg, ::testing::Not(HasSubstr("nan")));
}

TEST_F(Shake, OneRecordHasACurveWithoutABand) {
  const auto summary = run({"fragility", mesh_, "--shake", record("a.AT2", 1.0), "--scale", "0.1:2:0.1",
                            "--map-pga-steps", "0", "-o", out_, "--json"});
  const auto& rock = summary.at("rocks").as_array().at(0);
  EXPECT_THAT(rock.at("band").as_string(), HasSubstr("none"));
  EXPECT_FALSE(rock.at("logistic").at("with_ratio").as_bool());
  EXPECT_FALSE(fs::exists(fs::path(out_) / "block_overturning.svg"));
}

TEST_F(Shake, SameBytesOnAnyNumberOfThreads) {
  const auto at2 = record("a.AT2", 1.0), other = record("b.AT2", 3.0);
  const auto once = [&](const std::string& threads, const std::string& out) {
    const auto result =
        cairn({"fragility", mesh_, "--shake", at2, other, "--scale", "0.2:1:0.2", "--bootstrap-draws", "20",
               "--map-pga-steps", "6", "--map-ratio-steps", "4", "--threads", threads, "-o", out});
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return ::cairn::base::read_file(fs::path(out) / "block_shake.json") +
           ::cairn::base::read_file(fs::path(out) / "block_curve.csv") +
           ::cairn::base::read_file(fs::path(out) / "block_overturning.svg");
  };
  EXPECT_EQ(once("1", out_), once("2", (folder_ / "again").string()));
}

TEST_F(Shake, BadRecordsAreExitFourWithTheirLine) {
  ::cairn::base::write_file(folder_ / "bad.csv", "time,acc\n0,1\n0.01,2\n0.02,3\n");
  auto result = cairn({"fragility", mesh_, "--shake", (folder_ / "bad.csv").string(), "-o", out_});
  EXPECT_EQ(result.exit_code, 4);
  EXPECT_THAT(result.err, HasSubstr("names no unit"));
  ::cairn::base::write_file(folder_ / "uneven.csv", "time_s,a_m_s2\n0,1\n0.01,2\n0.05,3\n");
  result = cairn({"fragility", mesh_, "--shake", (folder_ / "uneven.csv").string(), "-o", out_});
  EXPECT_EQ(result.exit_code, 4);
  EXPECT_THAT(result.err, HasSubstr("not constant"));
  EXPECT_THAT(result.err, HasSubstr("uneven.csv"));
  EXPECT_FALSE(fs::exists(out_));
}

TEST_F(Shake, WrongScalesAreExitTwo) {
  const auto at2 = record("a.AT2", 1.0);
  for (const std::string scale : {"0:1:0.1", "2:1:0.1", "a", "1,0.5", "0.1:2"}) {
    const auto result = cairn({"fragility", mesh_, "--shake", at2, "--scale", scale, "-o", out_});
    EXPECT_EQ(result.exit_code, 2) << scale;
    EXPECT_THAT(result.err, HasSubstr("scale")) << scale;
  }
}

TEST_F(Shake, ModelWithoutCoefficientsIsRefused) {
  const auto result = cairn({"fragility", mesh_, "--shake", record("a.AT2", 1.0), "--scale", "0.5,1,2", "--model",
                             ::cairn::testing::sample("fragility_models/purvance2008.json").string(), "-o", out_});
  EXPECT_NE(result.exit_code, 0);
  EXPECT_THAT(result.err, HasSubstr("model purvance2008: coefficients not supplied"));
}

TEST_F(Shake, PulseTestsOfABlockOnAPlane) {
  ::cairn::base::write_file(folder_ / "tests.csv",
                            "test_no,pga_g,pgv_over_pga_s,overturned\n1,0.2,0.1,0\n2,3.0,0.4,1\n3,0.25,0.3,0\n");
  const auto summary = run({"fragility", mesh_, "--pulse-tests", (folder_ / "tests.csv").string(), "--vertex-noise-m",
                            "0", "--pulse-azimuth-deg", "90", "--contact-draws", "5", "-o", out_, "--json"});
  EXPECT_EQ(summary.at("accuracy").as_real(), 1.0);
  EXPECT_EQ(summary.at("brier").as_real(), 0.0);
  EXPECT_NEAR(summary.at("toppling_angle_deg").at("p50").as_real(), 18.434949, 1e-5);
  const auto csv = ::cairn::base::read_file(fs::path(out_) / "predictions.csv");
  EXPECT_THAT(csv, HasSubstr("2,3,0.4,1,1,1"));
}

}  // namespace
