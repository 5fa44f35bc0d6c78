#include "tracking/frame_order.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/error.hpp"

namespace {

using namespace cairn;
using tracking::FrameOrder;
using tracking::order_frames;

constexpr std::int64_t kSecond = 1'000'000'000;

std::vector<survey::Frame> frames_at(const std::vector<double>& seconds, std::int64_t camera = 1) {
  std::vector<survey::Frame> frames;
  for (const double s : seconds) {
    survey::Frame frame;
    frame.id = survey::FrameId(static_cast<std::int64_t>(frames.size()) + 1);
    frame.camera = survey::CameraId(camera);
    frame.time_ns = static_cast<std::int64_t>(s * static_cast<double>(kSecond));
    frames.push_back(frame);
  }
  return frames;
}

std::vector<std::size_t> order_of(const FrameOrder& order) {
  std::vector<std::size_t> list;
  for (const auto& step : order.steps) list.push_back(step.frame);
  return list;
}
std::vector<std::size_t> starts_of(const FrameOrder& order) {
  std::vector<std::size_t> list;
  for (std::size_t i = 0; i < order.steps.size(); ++i)
    if (order.steps[i].starts) list.push_back(i);
  return list;
}
std::vector<std::string> reasons_of(const FrameOrder& order) {
  std::vector<std::string> list;
  for (const auto& n : order.notices) list.push_back(n.reason);
  return list;
}

TEST(FrameOrder, WithoutTimesTheIdsDecide) {
  const auto order = order_frames(frames_at({0, 0, 0}), {});
  EXPECT_EQ(order_of(order), (std::vector<std::size_t>{0, 1, 2}));
  EXPECT_EQ(starts_of(order), (std::vector<std::size_t>{0}));
  EXPECT_TRUE(order.notices.empty());
}

TEST(FrameOrder, UnsortedFramesAreTakenInTime) {
  const auto order = order_frames(frames_at({10, 12, 11, 13, 14}), {});
  EXPECT_EQ(order_of(order), (std::vector<std::size_t>{0, 2, 1, 3, 4}));
  EXPECT_EQ(reasons_of(order), (std::vector<std::string>{"unsorted_frames"}));
}

TEST(FrameOrder, RealTimeIsInNominalPeriods) {
  tracking::FrameOrderOptions options;
  options.real_time = true;
  const auto order = order_frames(frames_at({10, 11, 12, 15, 16, 16}), options);
  std::vector<double> dt;
  for (const auto& step : order.steps) dt.push_back(step.dt);
  EXPECT_THAT(dt, ::testing::ElementsAre(1.0, 1.0, 1.0, 3.0, 1.0, 1e-3));
  EXPECT_EQ(reasons_of(order), (std::vector<std::string>{"duplicate_time"}));
}

TEST(FrameOrder, AClockThatWasSetAnewEndsTheTracks) {
  const auto order = order_frames(frames_at({1000, 1001, 1002, 0.5, 1.5, 2.5}), {});
  EXPECT_EQ(order_of(order), (std::vector<std::size_t>{0, 1, 2, 3, 4, 5}));
  EXPECT_EQ(starts_of(order), (std::vector<std::size_t>{0, 3}));
  EXPECT_EQ(reasons_of(order), (std::vector<std::string>{"clock_jump"}));
}

TEST(FrameOrder, AJumpForwardEndsTheTracks) {
  const auto order = order_frames(frames_at({1, 2, 3, 500, 501}), {});
  EXPECT_EQ(starts_of(order), (std::vector<std::size_t>{0, 3}));
  EXPECT_EQ(reasons_of(order), (std::vector<std::string>{"clock_jump"}));
}

TEST(FrameOrder, CamerasAreSequencesOfTheirOwn) {
  auto frames = frames_at({1, 1, 2, 2});
  for (const std::size_t i : {std::size_t{1}, std::size_t{3}}) frames[i].camera = survey::CameraId(2);
  const auto order = order_frames(frames, {});
  EXPECT_EQ(order_of(order), (std::vector<std::size_t>{0, 2, 1, 3}));
  EXPECT_EQ(starts_of(order), (std::vector<std::size_t>{0, 2}));
  EXPECT_TRUE(order.notices.empty());
}

TEST(FrameOrder, ExtremeTimeStampsDoNotOverflow) {
  auto frames = frames_at({0, 1, 2});
  frames[0].time_ns = INT64_MIN;
  frames[2].time_ns = INT64_MAX;
  for (const auto& step : order_frames(frames, {.real_time = true}).steps) EXPECT_GT(step.dt, 0.0);
  EXPECT_THROW(static_cast<void>(order_frames(frames, {.clock_jump = 0.5})), base::Error);
}

}  // namespace
