#include "io/accelerogram.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "support/data.hpp"

namespace cairn::io {
namespace {

using cairn::testing::TempFolder;
using ::testing::HasSubstr;

constexpr double kG = 9.80665;

class Records : public ::testing::Test {
 protected:
  TempFolder folder_;
  [[nodiscard]] std::string write(const std::string& name, const std::string& content) const {
    base::write_file(folder_ / name, content);
    return (folder_ / name).string();
  }
  [[nodiscard]] survey::Accelerogram read(const std::string& name, const std::string& content,
                                          const RecordOptions& options = {}) const {
    const auto list = read_accelerograms(write(name, content), options);
    EXPECT_EQ(list.size(), 1U);
    return list.at(0);
  }
  // The error of a refused file; its whole text.
  [[nodiscard]] std::string refusal(const std::string& name, const std::string& content,
                                    const RecordOptions& options = {}) const {
    const auto path = write(name, content);
    try {
      (void)read_accelerograms(path, options);
    } catch (const base::Error& e) {
      EXPECT_EQ(e.code(), base::ErrorCode::invalid_input);
      EXPECT_EQ(e.file(), path);
      return e.record() + ": " + e.what();
    }
    ADD_FAILURE() << "was read: " << content.substr(0, 60);
    return {};
  }
};

const std::string kAt2 =
    "PEER NGA STRONG MOTION DATABASE RECORD\n"
    "Made up, 1/2/1990, Nowhere - Old Mill, 090\n"
    "ACCELERATION TIME SERIES IN UNITS OF G\n";

TEST_F(Records, At2) {
  const auto r = read(
      "a.AT2", kAt2 + "NPTS=   7, DT=   .0050 SEC,\n  .1000000E+00 -.2000000E+00  .3E+00  .4E+00  .5E+00\n .6 .7\n");
  EXPECT_EQ(r.format, "peer_at2");
  EXPECT_EQ(r.name, "a");
  EXPECT_EQ(r.event, "Made up");
  EXPECT_EQ(r.station, "Nowhere - Old Mill");
  EXPECT_EQ(r.component, "090");
  EXPECT_EQ(r.azimuth_deg, 90.0);
  EXPECT_FALSE(r.vertical);
  EXPECT_EQ(r.dt_s, 0.005);
  ASSERT_EQ(r.acceleration.size(), 7U);
  EXPECT_DOUBLE_EQ(r.acceleration[1], -0.2 * kG);
  EXPECT_TRUE(r.notes.empty());
}

TEST_F(Records, At2OldHeaderAndCarriageReturns) {
  const auto r = read("a.AT2",
                      "TITLE\r\nEvent, 1/1/80, Site, UP\r\nACCELERATION TIME HISTORY IN UNITS OF G\r\n   4    0.0100   "
                      " NPTS, DT\r\n 1 2\r\n 3 4\r\n");
  EXPECT_EQ(r.dt_s, 0.01);
  EXPECT_EQ(r.acceleration.size(), 4U);
  EXPECT_TRUE(r.vertical);
}

TEST_F(Records, At2DownwardComponentIsTurned) {
  const auto r = read("a.AT2", "T\nEvent, 1/1/80, Site, DWN\nUNITS OF G\nNPTS= 2, DT= .01 SEC\n 1.0 2.0\n");
  EXPECT_TRUE(r.vertical);
  EXPECT_DOUBLE_EQ(r.acceleration[0], -kG);
  EXPECT_EQ(r.notes.size(), 1U);
}

TEST_F(Records, ValuesThatRunTogetherArePartedWhereTwoAreCertain) {
  const auto r = read("a.AT2", kAt2 + "NPTS= 4, DT= .01 SEC\n1.2-3.4 5.0E-01-6.0E-02\n");
  ASSERT_EQ(r.acceleration.size(), 4U);
  EXPECT_DOUBLE_EQ(r.acceleration[0], 1.2 * kG);
  EXPECT_DOUBLE_EQ(r.acceleration[1], -3.4 * kG);
  EXPECT_DOUBLE_EQ(r.acceleration[3], -0.06 * kG);
  // Two values, or 1.2e-103?
  const auto why = refusal("b.AT2", kAt2 + "NPTS= 2, DT= .01 SEC\n1.2-103\n");
  EXPECT_THAT(why, HasSubstr("line 5"));
  EXPECT_THAT(why, HasSubstr("1.2-103"));
}

TEST_F(Records, At2CountIsChecked) {
  EXPECT_THAT(refusal("a.AT2", kAt2 + "NPTS= 5, DT= .01 SEC\n1.0 2.0 3.0 4.0\n"), HasSubstr("ends early"));
  EXPECT_THAT(refusal("a.AT2", kAt2 + "NPTS= 5, DT= .01 SEC\n1.0 2.0 3.0 4.0\n"), HasSubstr("line 4"));
  EXPECT_THAT(refusal("a.AT2", kAt2 + "NPTS= 4000000000, DT= .01 SEC\n1.0 2.0\n"), HasSubstr("cannot be right"));
  EXPECT_THAT(refusal("a.AT2", kAt2 + "NPTS= -3, DT= .01 SEC\n1.0 2.0\n"), HasSubstr("cannot be right"));
  const auto r = read("a.AT2", kAt2 + "NPTS= 2, DT= .01 SEC\n1.0 2.0 3.0\n");
  EXPECT_EQ(r.acceleration.size(), 2U);
  EXPECT_EQ(r.notes.size(), 1U);
}

TEST_F(Records, At2WithoutUnitOrStepIsRefused) {
  const std::string bare = "T\nEvent, 1/1/80, Site, 090\nACCELERATION TIME SERIES\nNPTS= 2, DT= .01 SEC\n1.0 2.0\n";
  EXPECT_THAT(refusal("a.AT2", bare), HasSubstr("names no unit"));
  EXPECT_THAT(refusal("a.AT2", bare), HasSubstr("line 3"));
  EXPECT_DOUBLE_EQ(read("a.AT2", bare, {"cm/s2", ""}).acceleration[1], 0.02);
  EXPECT_THAT(refusal("a.AT2", kAt2 + "NPTS= 2\n1.0 2.0\n"), HasSubstr("its step"));
  EXPECT_THAT(refusal("a.AT2", kAt2 + "NPTS= 2, DT= 0 SEC\n1.0 2.0\n"), HasSubstr("step of the record"));
  EXPECT_THAT(
      refusal("a.VT2", "T\nE, d, S, 090\nVELOCITY TIME SERIES IN UNITS OF CM/S\nNPTS= 2, DT= .01 SEC\n1.0 2.0\n"),
      HasSubstr("velocity"));
}

TEST_F(Records, WordsAndInfinitiesAreRefused) {
  for (const std::string word : {"abc", "nan", "inf", "1.0E", "1e999", "1.2.3", "--1"}) {
    const auto why = refusal("a.AT2", kAt2 + "NPTS= 2, DT= .01 SEC\n1.0 " + word + "\n");
    EXPECT_THAT(why, HasSubstr("line 5")) << word;
    EXPECT_THAT(why, HasSubstr(word)) << word;
  }
}

std::string smc(const std::string& count, const std::string& body) {
  std::string text = "2 CORRECTED ACCELEROGRAM\n";
  for (int i = 0; i < 10; ++i) text += "*\n";
  for (int line = 0; line < 6; ++line)
    for (int k = 0; k < 8; ++k) {
      std::string cell = line == 1 && k == 7 ? "1" : line == 2 && k == 0 ? count : "-32768";
      text += std::string(10 - cell.size(), ' ') + cell + (k == 7 ? "\n" : "");
    }
  for (int line = 0; line < 10; ++line)
    for (int k = 0; k < 5; ++k)
      text += (line == 0 && k == 1 ? "  0.5000000E+02" : "  0.1700000E+39") + std::string(k == 4 ? "\n" : "");
  return text + "| one comment\n" + body;
}

TEST_F(Records, Smc) {
  const auto r =
      read("a.smc", smc("6", " 9.5746585E-04 4.5568822E-03-5.7981615E-03 7.4581211E-03 5.1E+00\n-1.0E+01\n"));
  EXPECT_EQ(r.format, "smc");
  EXPECT_DOUBLE_EQ(r.dt_s, 0.02);
  ASSERT_EQ(r.acceleration.size(), 6U);
  EXPECT_DOUBLE_EQ(r.acceleration[2], -5.7981615e-5);
  EXPECT_DOUBLE_EQ(r.acceleration[5], -0.1);
  EXPECT_THAT(refusal("b.smc", smc("7", " 1.0 2.0\n")), HasSubstr("ends early"));
  EXPECT_THAT(refusal("b.smc", smc("7000000", " 1.0 2.0\n")), HasSubstr("cannot be right"));
}

TEST_F(Records, CosmosWithTwoChannels) {
  const std::string block = " acceleration pts, approx 0 secs, units=cm/sec2(04), Format=(8f10.5)\n";
  const std::string text =
      "Corrected acceleration (Format v01.20 with 13 text lines)\n"
      "Station No. 12345\n"
      "Chan  1:   90 Deg\n"
      "Raw at 200.0 samples/sec\n"
      "        4" +
      block +
      "   1.00000  -2.00000   3.00000-444.00000\n"
      "        4 velocity pts, units=cm/sec\n  9.0 9.0 9.0 9.0\n"
      "End-of-data for Chan 1\n"
      "Chan  2:  Up\n"
      "        3" +
      block +
      "   1.5\n   2.5\n   3.5\n"
      "End-of-data for Chan 2\n";
  const auto list = read_accelerograms(write("c.V2", text));
  ASSERT_EQ(list.size(), 2U);
  EXPECT_DOUBLE_EQ(list[0].dt_s, 0.005);
  ASSERT_EQ(list[0].acceleration.size(), 4U);
  EXPECT_DOUBLE_EQ(list[0].acceleration[3], -4.44);
  EXPECT_DOUBLE_EQ(list[1].acceleration[2], 0.035);
  EXPECT_TRUE(list[1].vertical);
}

TEST_F(Records, CosmosWithoutAStepIsRefused) {
  EXPECT_THAT(refusal("c.V2", "Corrected\n   2 acceleration pts, units=cm/sec2\n 1.0 2.0\n"), HasSubstr("its step"));
  EXPECT_THAT(refusal("c.V2", "x\n 2 points of accel data equally spaced at .02 sec\n 1.0 2.0\n"),
              HasSubstr("no unit"));
}

TEST_F(Records, VelocityTables) {
  const auto r = read("a.tab", "A NAME\n4,0.5\n0.0\n1.0\n3.0\n2.0\n");
  EXPECT_EQ(r.format, "velocity_table");
  EXPECT_EQ(r.event, "A NAME");
  EXPECT_EQ(r.acceleration, (std::vector<double>{0.0, 2.0, 4.0, -2.0, 0.0}));
  const auto s = read("b.tab", "# number of velocity points: 3, dt: 0.005\n0.0\n0.01\n0.03\n");
  EXPECT_DOUBLE_EQ(s.dt_s, 0.005);
  EXPECT_NEAR(s.acceleration[2], 4.0, 1e-12);
  EXPECT_THAT(refusal("c.tab", "A NAME\n5,0.5\n0.0\n1.0\n3.0\n2.0\n"), HasSubstr("ends early"));
  EXPECT_THAT(refusal("c.tab", "A NAME\n4,0.5\n0.0\n1.0\n3.0-1.0\n2.0\n"), HasSubstr("line 5"));
}

TEST_F(Records, ColumnsWithTheirUnit) {
  const auto r = read("a.csv", "time_s,a_m_s2\n0,1\n0.01,2\n0.02,-3\n");
  EXPECT_EQ(r.acceleration, (std::vector<double>{1, 2, -3}));
  EXPECT_DOUBLE_EQ(r.dt_s, 0.01);
  EXPECT_DOUBLE_EQ(read("b.txt", "# time [s]  acceleration [g]\n0 1\n.5 2\n1 3\n").acceleration[1], 2 * kG);
  EXPECT_DOUBLE_EQ(read("c.txt", "0;100\n.5;200\n1;300\n", {"cm/s2", ""}).acceleration[2], 3.0);
  EXPECT_DOUBLE_EQ(
      read("d.csv", "\xEF\xBB\xBFTime [s],Acceleration [g],Velocity [m/s]\n0,1,0\n1,2,0\n2,3,0\n").acceleration[0], kG);
}

TEST_F(Records, ColumnsWithoutAUnitAreRefused) {
  const auto why = refusal("a.csv", "time,acc\n0,1\n0.01,2\n0.02,3\n");
  EXPECT_THAT(why, HasSubstr("names no unit"));
  EXPECT_THAT(why, HasSubstr("--record-unit"));
  EXPECT_THAT(refusal("b.txt", "0 1\n1 2\n2 3\n"), HasSubstr("names no unit"));
}

TEST_F(Records, AnUnevenStepIsRefusedWithItsLine) {
  const auto why = refusal("a.csv", "time_s,a_m_s2\n0,1\n0.01,2\n0.02,3\n0.04,4\n0.05,5\n");
  EXPECT_THAT(why, HasSubstr("step of the record is not constant"));
  EXPECT_THAT(why, HasSubstr("line 3"));
  EXPECT_THAT(refusal("a.csv", "time_s,a_m_s2\n0,1\n0.02,2\n0.01,3\n0.03,4\n"), HasSubstr("not constant"));
  // Times rounded to three decimals are even enough.
  const auto r = read("b.csv", "time_s,a_m_s2\n0,1\n0.008,2\n0.016,3\n0.023,4\n0.031,5\n0.039,6\n0.047,7\n");
  EXPECT_NEAR(r.dt_s, 0.0078333, 1e-6);
}

TEST_F(Records, ColumnsThatCannotBeReadAreRefused) {
  EXPECT_THAT(refusal("a.csv", "time_s,a_m_s2\n0,1\n0.01,1.2-3.4\n0.02,3\n"), HasSubstr("line 3"));
  EXPECT_THAT(refusal("a.csv", "time_s,a_m_s2\n0,1\n0.01\n0.02,3\n"), HasSubstr("columns"));
  EXPECT_THAT(refusal("a.csv", "time_s,raw_acc_g,filtered_acc_g\n0,1,1\n1,2,2\n2,3,3\n"), HasSubstr("--record-column"));
  EXPECT_DOUBLE_EQ(read("a.csv", "time_s,raw_acc_g,filtered_acc_g\n0,1,1\n1,2,5\n2,3,3\n", {"none", "filtered_acc_g"})
                       .acceleration[1],
                   5 * kG);
  EXPECT_THAT(refusal("a.csv", "only words\nand more\n"), HasSubstr("no row of numbers"));
  EXPECT_THAT(refusal("a.txt", "dt=0.005\nacc: m/s2\n1.0\n2.0\n"), HasSubstr("single column"));
  EXPECT_THROW((void)read_accelerograms(folder_ / "none.AT2"), base::Error);
  EXPECT_THROW((void)read_accelerograms(write("empty.AT2", "")), base::Error);
  EXPECT_THROW((void)read_accelerograms(write("bytes.AT2", std::string("a\0b\n", 4))), base::Error);
}

TEST_F(Records, ARealTable) {
  const auto r = read_accelerograms(cairn::testing::test_data("accelerograms/test_motion_avd.csv")).at(0);
  EXPECT_EQ(r.acceleration.size(), 4684U);
  EXPECT_NEAR(r.dt_s, 0.01, 1e-12);
  EXPECT_DOUBLE_EQ(r.acceleration[3], 6.98267e-05 * kG);
}

}  // namespace
}  // namespace cairn::io
