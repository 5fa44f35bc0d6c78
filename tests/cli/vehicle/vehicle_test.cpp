#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/atomic_file.hpp"
#include "io/json.hpp"
#include "io/packets.hpp"
#include "io/survey_folder.hpp"
#include "io/vehicle_csv.hpp"
#include "support/data.hpp"
#include "support/ground_drive.hpp"
#include "support/run_program.hpp"

namespace {

namespace fs = std::filesystem;
using cairn::testing::cairn;
using cairn::testing::TempFolder;
using cairn::testing::test_data;
using ::testing::HasSubstr;
namespace base = ::cairn::base;
namespace io = ::cairn::io;

class VehicleCommand : public ::testing::Test {
 protected:
  TempFolder folder_;
  fs::path survey_ = folder_ / "survey", out_ = folder_ / "out";
  cairn::testing::Drive drive_;

  void SetUp() override {
    cairn::testing::DriveOptions options;
    options.duration_s = 90.0;
    drive_ = cairn::testing::make_drive(options, 1);
    cairn::survey::Survey survey;
    survey.manifest.name = "drive";
    survey.manifest.origin.position = {46.8426, -91.994, 158.0};
    survey.manifest.origin.height_type = cairn::survey::HeightType::ellipsoidal;
    survey.manifest.time_base = base::TimeBase::gps;
    fs::create_directories(survey_ / "truth");
    io::write_survey(survey, survey_);
    io::write_vehicle_csv(survey_ / "vehicle.csv", drive_.log);
    io::write_vehicle_csv(survey_ / "truth/vehicle.csv", drive_.truth);
    io::write_packets(survey_ / "packets.bin", drive_.packets, base::TimeBase::gps);
  }
  [[nodiscard]] ::cairn::testing::ProgramResult run(const std::vector<std::string>& more = {}) const {
    std::vector<std::string> arguments{"vehicle", survey_.string(), "-o", out_.string()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return cairn(arguments);
  }
};

TEST_F(VehicleCommand, WritesTrackComparisonResidualsAndErrors) {
  const auto result = run({"--json"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto summary = io::parse_json(result.out, "stdout");
  EXPECT_EQ(summary.at("states").as_integer(), 90 * 25 + 1);
  EXPECT_LT(summary.at("errors").at("filter").at("rms_m").as_real(), 0.35);  // a short drive, its start included
  EXPECT_GT(summary.at("errors").at("log_alone").at("rms_m").as_real(), 0.5);
  EXPECT_GT(summary.at("bandwidth").at("image_raw").at("times_packets").as_real(), 1000.0);
  EXPECT_GT(summary.at("positions").at("refused_by_reason").at("impossible_move").as_integer(), 0);
  const auto track = io::read_vehicle_csv(out_ / "vehicle.csv");
  ASSERT_EQ(track.size(), 90U * 25U + 1U);
  EXPECT_TRUE(track.back().covariance);
  EXPECT_THAT(base::read_file(out_ / "residuals.csv"), HasSubstr("impossible_move"));
  EXPECT_THAT(base::read_file(out_ / "comparison.csv"), HasSubstr("truth_x_m"));
  EXPECT_THAT(base::read_file(out_ / "vehicle.svg"), HasSubstr("Error [m]"));
  EXPECT_TRUE(fs::exists(out_ / "run.json"));
  EXPECT_EQ(io::read_json(out_ / "vehicle.json"), summary);
}

TEST_F(VehicleCommand, SameBytesOnAnyNumberOfThreads) {
  ASSERT_EQ(run({"--threads", "1"}).exit_code, 0);
  const auto first = base::read_file(out_ / "vehicle.csv"), plot = base::read_file(out_ / "vehicle.svg");
  ASSERT_EQ(run({"--threads", "2", "--overwrite"}).exit_code, 0);
  EXPECT_EQ(base::read_file(out_ / "vehicle.csv"), first);
  EXPECT_EQ(base::read_file(out_ / "vehicle.svg"), plot);
}

TEST_F(VehicleCommand, PaperModeAndReplay) {
  const auto result = run({"--mode", "paper", "--replay", "--link-profile", "park", "--seed", "3", "--json"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto summary = io::parse_json(result.out, "stdout");
  EXPECT_EQ(summary.at("mode").as_string(), "paper");
  const auto& replay = summary.at("packets").at("replay");
  EXPECT_EQ(replay.at("sent").as_integer(), static_cast<std::int64_t>(drive_.packets.size()));
  EXPECT_EQ(io::read_packets(out_ / "packets_replayed.bin").size(),
            static_cast<std::size_t>(replay.at("delivered").as_integer()));
}

TEST_F(VehicleCommand, RealLogsRun) {
  for (const auto* log : {"plaza/Plaza1_DR.txt", "plaza/KittiGps_converted.txt", "tum/fr2_desk_groundtruth.txt"}) {
    const auto result = cairn({"vehicle", test_data(log).string(), "-o", out_.string(), "--overwrite", "--json"});
    ASSERT_TRUE(result.exit_code == 0 || result.exit_code == 3) << log << result.err;
    const auto summary = io::parse_json(result.out, "stdout");
    EXPECT_GT(summary.at("distance_m").as_real(), 5.0) << log;
    EXPECT_EQ(summary.at("packets").at("count").as_integer(), 0);
  }
}

TEST_F(VehicleCommand, PositionsFromATable) {
  // The car's own fixes, seen from above once more.
  const auto log = test_data("plaza/KittiGps_converted.txt").string();
  const auto result = cairn({"vehicle", log, "--positions", log, "-o", out_.string(), "--json"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto summary = io::parse_json(result.out, "stdout");
  EXPECT_EQ(summary.at("packets").at("source").as_string(), "positions");
  EXPECT_GT(summary.at("positions").at("taken").as_integer(), 450);
}

TEST_F(VehicleCommand, ATruncatedRecordingIsUsedAndTold) {
  const auto whole = base::read_file(survey_ / "packets.bin");
  base::write_file(survey_ / "packets.bin", whole.substr(0, whole.size() / 2));
  const auto result = run({"--json"});
  EXPECT_EQ(result.exit_code, 3) << result.err;
  const auto summary = io::parse_json(result.out, "stdout");
  EXPECT_EQ(summary.at("rejects_by_reason").at("truncated").as_integer(), 1);
  EXPECT_EQ(summary.at("rejects_by_reason").at("wrong_count").as_integer(), 1);
  EXPECT_GT(summary.at("packets").at("count").as_integer(), 10);
}

TEST_F(VehicleCommand, GapsOfTheLogAreTold) {
  auto log = drive_.log;
  log.erase(log.begin() + 1000, log.begin() + 1500);  // 10 s
  io::write_vehicle_csv(survey_ / "vehicle.csv", log);
  const auto result = run({"--json"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto summary = io::parse_json(result.out, "stdout");
  EXPECT_EQ(summary.at("log").at("gaps").as_integer(), 1);
  EXPECT_NEAR(summary.at("log").at("longest_gap_s").as_real(), 10.02, 1e-9);
  EXPECT_THAT(result.err, HasSubstr("1 gaps"));
  EXPECT_LT(summary.at("errors").at("filter").at("max_m").as_real(), 12.0);
}

TEST_F(VehicleCommand, TimeBasesMustAgreeOrAnOffsetBeGiven) {
  io::write_packets(survey_ / "packets.bin", drive_.packets, base::TimeBase::boot);
  const auto refused = run();
  EXPECT_EQ(refused.exit_code, 4);
  EXPECT_THAT(refused.err, HasSubstr("different time bases"));
  EXPECT_THAT(refused.err, HasSubstr("--packet-offset-s"));
  EXPECT_EQ(run({"--packet-offset-s", "0"}).exit_code, 0);

  auto shifted = drive_.packets;
  for (auto& p : shifted) {
    p.arrival_time_ns += 18'000'000'000'000;
    p.packet.capture_time_ns += 18'000'000'000'000;
  }
  io::write_packets(survey_ / "packets.bin", shifted, base::TimeBase::gps);
  const auto apart = run({"--overwrite"});
  EXPECT_EQ(apart.exit_code, 4);
  EXPECT_THAT(apart.err, HasSubstr("no time in common"));
  const auto joined = run({"--overwrite", "--packet-offset-s", "-18000", "--json"});
  ASSERT_EQ(joined.exit_code, 0) << joined.err;
  EXPECT_LT(io::parse_json(joined.out, "stdout").at("errors").at("filter").at("rms_m").as_real(), 0.35);
}

TEST_F(VehicleCommand, BadInput) {
  fs::remove(survey_ / "vehicle.csv");
  auto result = run();
  EXPECT_EQ(result.exit_code, 4);
  EXPECT_THAT(result.err, HasSubstr("has no vehicle.csv"));
  base::write_file(survey_ / "vehicle.csv", "time_ns,x_m\n0,1\n");
  EXPECT_EQ(run().exit_code, 4);
  EXPECT_EQ(run({"--projector-sigma-m", "-1"}).exit_code, 2);
  EXPECT_EQ(run({"--packet-offset-s", "soon"}).exit_code, 2);
  base::write_file(survey_ / "packets.bin", "no packets");
  io::write_vehicle_csv(survey_ / "vehicle.csv", drive_.log);
  result = run();
  EXPECT_EQ(result.exit_code, 4);
  EXPECT_THAT(result.err, HasSubstr("not a recording of packets"));
}

}  // namespace
