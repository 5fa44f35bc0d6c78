#include "pipeline/check_findings.hpp"

#include <gtest/gtest.h>

namespace cairn::pipeline {
namespace {

TEST(Findings, ErrorsComeFirstAndKeepTheirOrder) {
  Findings findings;
  findings.add({"b", Severity::info, "", "", "", ""});
  findings.add({"a", Severity::error, "", "1", "", ""});
  findings.add({"c", Severity::warning, "", "", "", ""});
  findings.add({"a", Severity::error, "", "2", "", ""});
  const auto list = findings.list();
  ASSERT_EQ(list.size(), 4U);
  EXPECT_EQ(list[0].record, "1");
  EXPECT_EQ(list[1].record, "2");
  EXPECT_EQ(list[2].code, "c");
  EXPECT_EQ(list[3].code, "b");
}

TEST(Findings, ManyOfOneCodeAreCountedNotListed) {
  Findings findings(3);
  for (int i = 0; i < 10; ++i) findings.add({"a", Severity::error, "f", std::to_string(i), "m", "h"});
  EXPECT_EQ(findings.count(Severity::error), 10U);
  const auto list = findings.list();
  ASSERT_EQ(list.size(), 4U);
  EXPECT_EQ(list[3].record, "7 more records");
}

TEST(Findings, ErrorsTellFoundAllowedAndRemedy) {
  Findings findings;
  findings.add("x",
               base::Error(base::ErrorCode::invalid_input, "too many legs")
                   .file("zoo.csv")
                   .record("line 2")
                   .found("5")
                   .allowed("0 to 4")
                   .hint("Count again"),
               "frame 7");
  const auto f = findings.list().at(0);
  EXPECT_EQ(f.file, "zoo.csv");
  EXPECT_EQ(f.record, "line 2 (frame 7)");
  EXPECT_EQ(f.message, "too many legs (found 5; allowed 0 to 4)");
  EXPECT_EQ(f.hint, "Count again");
}

}  // namespace
}  // namespace cairn::pipeline
