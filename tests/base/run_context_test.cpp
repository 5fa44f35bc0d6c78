#include "base/run_context.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/error.hpp"

namespace cairn::base {
namespace {

class Collector final : public Listener {
 public:
  std::vector<std::string> messages;
  void message(LogLevel, std::string_view text) override { messages.emplace_back(text); }
  void progress(std::string_view, std::uint64_t, std::uint64_t) override {}
};

TEST(RunContext, KeepsWarningsForTheRecord) {
  Collector collector;
  RunContext ctx(&collector, nullptr);
  ctx.info("one");
  ctx.warn("two");
  EXPECT_THAT(collector.messages, ::testing::ElementsAre("one", "two"));
  EXPECT_THAT(ctx.warnings(), ::testing::ElementsAre("two"));
}

TEST(RunContext, StopsWhenAsked) {
  StopFlag stop;
  const RunContext ctx(nullptr, &stop);
  EXPECT_NO_THROW(ctx.check_stop());
  stop.request();
  try {
    ctx.check_stop();
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ErrorCode::cancelled);
  }
}

TEST(RunContext, RefusesMemoryBeyondTheLimit) {
  RunContext ctx;
  EXPECT_NO_THROW(ctx.check_memory(UINT64_MAX / 2, "anything"));
  ctx.memory_limit_bytes = std::uint64_t{8} << 30;
  EXPECT_NO_THROW(ctx.check_memory(1 << 20, "a little"));
  EXPECT_THROW(ctx.check_memory(std::uint64_t{9} << 30, "a lot"), Error);
}

}  // namespace
}  // namespace cairn::base
