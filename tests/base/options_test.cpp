#include "base/options.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/error.hpp"

namespace cairn::base {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

struct Options {
  double range_m = 2.5;
  std::int64_t points = 2000;
  bool merge = true;
  std::string mode = "robust";
  void visit(OptionVisitor& v) {
    v.real("range-m", range_m, 0.0, 10.0, "reach");
    v.integer("points", points, 1, 100000, "points a target");
    v.flag("merge", merge, "merge duplicates");
    v.choice("mode", mode, {"paper", "robust"}, "which letter");
  }
};

TEST(Options, DefaultsAreValid) {
  Options o;
  EXPECT_TRUE(problems(bind_options(o)).empty());
}

TEST(Options, AllProblemsAreListedAtOnce) {
  Options o;
  o.range_m = -1.0;
  o.points = 0;
  o.mode = "other";
  EXPECT_THAT(problems(bind_options(o)),
              ElementsAre("range-m = -1 (allowed 0 to 10)", "points = 0 (allowed 1 to 100000)",
                          "mode = 'other' (allowed paper, robust)"));
  EXPECT_THROW(validate(bind_options(o), "locate"), Error);
}

TEST(Options, NotANumberIsOutOfRange) {
  Options o;
  o.range_m = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(problems(bind_options(o)).size(), 1U);
}

TEST(Options, SetFromText) {
  Options o;
  const auto visit = bind_options(o);
  set_option(visit, "range-m", "0.25");
  set_option(visit, "merge", "false");
  set_option(visit, "mode", "paper");
  EXPECT_EQ(o.range_m, 0.25);
  EXPECT_FALSE(o.merge);
  EXPECT_EQ(o.mode, "paper");
  try {
    set_option(visit, "rnge-m", "1");
    FAIL();
  } catch (const Error& e) {
    EXPECT_THAT(e.what(), HasSubstr("range-m, points, merge, mode"));
  }
  EXPECT_THROW(set_option(visit, "points", "1.5"), Error);
}

TEST(Options, TextsKeepOrderAndRoundTrip) {
  Options o;
  o.range_m = 0.1;
  const auto texts = option_texts(bind_options(o));
  ASSERT_EQ(texts.size(), 4U);
  EXPECT_EQ(texts[0].name, "range-m");
  EXPECT_EQ(texts[0].value, "0.1");
}

}  // namespace
}  // namespace cairn::base
