#include "base/number_text.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "base/random.hpp"

namespace cairn::base {
namespace {

TEST(NumberText, RoundTripsEveryDouble) {
  Random random(1, "number_text", 0);
  for (int i = 0; i < 20000; ++i) {
    const std::uint64_t bits = random.bits();
    double value = 0.0;
    std::memcpy(&value, &bits, sizeof value);
    if (!std::isfinite(value) || value == 0.0) continue;
    EXPECT_EQ(parse_real(to_text(value)), value);
  }
}

TEST(NumberText, ZeroHasNoSign) {
  EXPECT_EQ(to_text(-0.0), "0");
  EXPECT_EQ(to_fixed(-0.0001, 2), "0.00");
  EXPECT_EQ(to_fixed(-0.01, 2), "-0.01");
}

TEST(NumberText, ParsesWholeTextsOnly) {
  EXPECT_EQ(parse_real(" +39.80\n"), 39.80);
  EXPECT_EQ(parse_real("-1.5e3"), -1500.0);
  for (const auto* text : {"", " ", "1,5", "1.5x", "+-1", "0x10", "1 2"}) EXPECT_FALSE(parse_real(text)) << text;
  EXPECT_EQ(parse_integer("42"), 42);
  for (const auto* text : {"4.2", "9223372036854775808", "a"}) EXPECT_FALSE(parse_integer(text)) << text;
}

}  // namespace
}  // namespace cairn::base
