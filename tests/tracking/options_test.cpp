#include "tracking/options.hpp"

#include <gtest/gtest.h>

#include "base/error.hpp"

namespace {

using cairn::tracking::resolved;
using cairn::tracking::SortOptions;

TEST(SortOptions, PresetsFillWhatIsNotGiven) {
  SortOptions sort = resolved({});
  EXPECT_EQ(sort.min_hits, 3);
  EXPECT_EQ(sort.max_age, 1);
  EXPECT_EQ(sort.emit_age, 0);
  EXPECT_EQ(sort.streak, "reset");
  SortOptions paper;
  paper.preset = "paper";
  paper.max_age = 50;
  paper = resolved(paper);
  EXPECT_EQ(paper.min_hits, 10);
  EXPECT_EQ(paper.max_age, 50);
  EXPECT_EQ(paper.emit_age, 49);
  EXPECT_EQ(paper.streak, "keep");
}

TEST(SortOptions, RefusesWhatMakesNoSense) {
  SortOptions o;
  o.emit_age = 2;
  EXPECT_THROW(static_cast<void>(resolved(o)), cairn::base::Error);
  o = {};
  o.iou = 1.5;
  EXPECT_THROW(static_cast<void>(resolved(o)), cairn::base::Error);
  o = {};
  o.preset = "fast";
  EXPECT_THROW(static_cast<void>(resolved(o)), cairn::base::Error);
}

}  // namespace
