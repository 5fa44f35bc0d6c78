#include "base/time.hpp"

#include <gtest/gtest.h>

namespace cairn::base {
namespace {

TEST(Time, CivilToNanosecondsAndBack) {
  const auto t = civil_to_ns(2016, 6, 23, 16, 31, 59.0);
  ASSERT_TRUE(t);
  EXPECT_EQ(*t, 1466699519000000000LL);
  EXPECT_EQ(iso8601(*t), "2016-06-23T16:31:59.000");
  EXPECT_EQ(iso8601(-1'000'000), "1969-12-31T23:59:59.999");
}

TEST(Time, RefusesImpossibleDates) {
  EXPECT_FALSE(civil_to_ns(2023, 2, 29, 0, 0, 0.0));
  EXPECT_FALSE(civil_to_ns(2023, 13, 1, 0, 0, 0.0));
  EXPECT_FALSE(civil_to_ns(2023, 1, 1, 24, 0, 0.0));
  EXPECT_FALSE(civil_to_ns(2023, 1, 1, 0, 0, -1.0));
}

TEST(Time, NamesRoundTrip) {
  for (const auto base : {TimeBase::utc, TimeBase::gps, TimeBase::boot, TimeBase::unknown})
    EXPECT_EQ(time_base_from(name_of(base)), base);
  EXPECT_FALSE(time_base_from("tai"));
}

}  // namespace
}  // namespace cairn::base
