#include "io/csv.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

#include "base/atomic_file.hpp"
#include "base/random.hpp"
#include "support/data.hpp"

namespace cairn::io {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

using Rows = std::vector<std::vector<std::string>>;

Rows rows_of(CsvReader& table) {
  Rows rows;
  while (table.next()) {
    rows.emplace_back();
    for (std::size_t i = 0; i < table.header().size(); ++i) rows.back().emplace_back(table.text(i));
  }
  return rows;
}

Rows parse(std::string_view text) {
  CsvReader table(text, "t.csv", ',');
  return rows_of(table);
}

// What the parser says about a text it must refuse.
std::string refusal(std::string_view text) {
  try {
    parse(text);
  } catch (const base::Error& error) {
    EXPECT_EQ(error.code(), base::ErrorCode::invalid_input);
    EXPECT_EQ(error.file(), "t.csv");
    return error.what();
  }
  return "accepted";
}

TEST(Csv, ReadsPlainRows) {
  EXPECT_EQ(parse("a,b\n1,2\n3,4\n"), (Rows{{"1", "2"}, {"3", "4"}}));
}

TEST(Csv, LastLineNeedsNoEnd) {
  EXPECT_EQ(parse("a,b\n1,"), (Rows{{"1", ""}}));
}

TEST(Csv, TakesByteOrderMarkAndCrLf) {
  CsvReader table(
      "\xEF\xBB\xBF"
      "a,b\r\n1,2\r\n",
      "t.csv", ',');
  EXPECT_THAT(table.header(), ElementsAre("a", "b"));
  EXPECT_EQ(rows_of(table), (Rows{{"1", "2"}}));
}

TEST(Csv, QuotedCellsHoldSeparatorsQuotesAndLineEnds) {
  EXPECT_EQ(parse("a,b\n\"x,y\",\"say \"\"hi\"\"\"\n\"two\nlines\",\"\"\n"),
            (Rows{{"x,y", "say \"hi\""}, {"two\nlines", ""}}));
}

TEST(Csv, SkipsCommentsAndBlankLinesAndKeepsThoseBeforeTheHeader) {
  CsvReader table("# crs EPSG:32615\n\na\n# between\n1\n\r\n2\n", "t.csv", ',');
  EXPECT_THAT(table.comments(), ElementsAre("crs EPSG:32615"));
  EXPECT_EQ(rows_of(table), (Rows{{"1"}, {"2"}}));
}

TEST(Csv, LineNumbersCountQuotedLineEnds) {
  CsvReader table("a\n\"x\ny\"\nbad\n", "t.csv", ',');
  ASSERT_TRUE(table.next());
  EXPECT_EQ(table.line(), 2U);
  ASSERT_TRUE(table.next());
  EXPECT_EQ(table.line(), 4U);
}

TEST(Csv, TypedAccessNamesLineColumnAndValue) {
  CsvReader table("id,score\n7,0.5\n8x,nan\n", "t.csv", ',');
  ASSERT_TRUE(table.next());
  EXPECT_EQ(table.integer(0), 7);
  EXPECT_EQ(table.real(1), 0.5);
  ASSERT_TRUE(table.next());
  try {
    (void)table.integer(0);
    FAIL() << "8x is not a number";
  } catch (const base::Error& error) {
    EXPECT_EQ(error.record(), "line 3, column id");
    EXPECT_EQ(error.found(), "'8x'");
    EXPECT_THAT(error.allowed(), HasSubstr("whole number"));
  }
  EXPECT_THROW((void)table.real(1), base::Error) << "nan must not come in";
  EXPECT_THROW((void)table.integer(1, 0, 5), base::Error);
}

TEST(Csv, DecimalCommaIsNotANumber) {
  CsvReader table("x;y\n1,5;2\n", "t.csv", ';');
  ASSERT_TRUE(table.next());
  EXPECT_THROW((void)table.real(0), base::Error);
  EXPECT_EQ(table.real(1), 2.0);
}

TEST(Csv, MissingColumnIsNamedWithThoseThereAre) {
  CsvReader table("a,b\n", "t.csv", ',');
  try {
    (void)table.column("score");
    FAIL();
  } catch (const base::Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("'score' is missing"));
    EXPECT_THAT(error.what(), HasSubstr("a, b"));
  }
}

TEST(Csv, RefusesBadTables) {
  EXPECT_THAT(refusal(""), HasSubstr("header row"));
  EXPECT_THAT(refusal("# only a comment\n"), HasSubstr("header row"));
  EXPECT_THAT(refusal("a,,c\n"), HasSubstr("column without a name"));
  EXPECT_THAT(refusal("a,b,a\n"), HasSubstr("two columns of one name"));
  EXPECT_THAT(refusal("a,b\n1\n"), AllOf(HasSubstr("line 2"), HasSubstr("found 1"), HasSubstr("allowed 2")));
  EXPECT_THAT(refusal("a,b\n1,2,3\n"), HasSubstr("found 3"));
  EXPECT_THAT(refusal("a,b\n1,\"2\n3,4\n"), AllOf(HasSubstr("line 2"), HasSubstr("never closed")));
  EXPECT_THAT(refusal("a,b\n1,\"2\"x\n"), HasSubstr("after a closing quote"));
  EXPECT_THAT(refusal("a,b\n1,2\"x\n"), AllOf(HasSubstr("column b"), HasSubstr("quote inside")));
  EXPECT_THAT(refusal(std::string_view("a,b\n1,\0\n", 8)), HasSubstr("NUL"));
  EXPECT_THAT(refusal("a\n" + std::string(2 << 20, 'x')), HasSubstr("record too long"));
  EXPECT_THAT(refusal("a\n" + std::string(2 << 20, ',')), HasSubstr("too many cells"));
}

TEST(Csv, MissingFileIsNotFound) {
  try {
    CsvReader table("/nonexistent/t.csv");
    FAIL();
  } catch (const base::Error& error) {
    EXPECT_EQ(error.code(), base::ErrorCode::not_found);
  }
}

TEST(Csv, WriterQuotesWhatASpreadsheetWouldRun) {
  EXPECT_EQ(csv_quoted("=1+1"), "\"=1+1\"");
  EXPECT_EQ(csv_quoted("+x"), "\"+x\"");
  EXPECT_EQ(csv_quoted("-x"), "\"-x\"");
  EXPECT_EQ(csv_quoted("@x"), "\"@x\"");
  EXPECT_EQ(csv_quoted("#x"), "\"#x\"");
  EXPECT_EQ(csv_quoted("a\"b"), "\"a\"\"b\"");
  EXPECT_EQ(csv_quoted("plain text"), "plain text");
}

TEST(Csv, NegativeNumbersAreNotQuoted) {
  const testing::TempFolder folder;
  CsvWriter table(folder / "t.csv", {"x", "n"});
  table.cell(-1.5).cell(std::int64_t{-3}).end_row();
  table.finish();
  EXPECT_EQ(base::read_file(folder / "t.csv"), "x,n\n-1.5,-3\n");
}

TEST(Csv, NonFiniteNumbersBecomeEmptyCells) {
  const testing::TempFolder folder;
  CsvWriter table(folder / "t.csv", {"x", "y"});
  table.cell(std::numeric_limits<double>::quiet_NaN()).cell(HUGE_VAL).end_row();
  table.finish();
  EXPECT_EQ(base::read_file(folder / "t.csv"), "x,y\n,\n");
}

TEST(Csv, RowOfTheWrongLengthIsADefect) {
  const testing::TempFolder folder;
  CsvWriter table(folder / "t.csv", {"x", "y"});
  table.cell(1);
  EXPECT_THROW(table.end_row(), base::Error);
}

TEST(Csv, FullDiskIsReported) {
  try {
    CsvWriter table("/dev/full", {"x"});
    table.cell(1).end_row();
    table.finish();
    FAIL() << "/dev/full takes no byte";
  } catch (const base::Error& error) {
    EXPECT_EQ(error.code(), base::ErrorCode::resource_exhausted);
    EXPECT_EQ(error.file(), "/dev/full");
  }
}

// Any text of any characters comes back as it was.
TEST(Csv, TextRoundTripsExactly) {
  const testing::TempFolder folder;
  const std::string_view alphabet = "ab,\"\n\r =+-@#;\t\xC3\xA9";
  base::Random random(1, "csv", 0);
  Rows rows;
  for (int i = 0; i < 2000; ++i) {
    rows.emplace_back();
    for (int c = 0; c < 3; ++c) {
      std::string text;
      for (auto n = random.below(8); n > 0; --n) text += alphabet[random.below(alphabet.size())];
      rows.back().push_back(text);
    }
  }
  CsvWriter table(folder / "t.csv", {"a", "b", "c"});
  for (const auto& row : rows) {
    for (const auto& cell : row) table.cell(cell);
    table.end_row();
  }
  table.finish();
  CsvReader reader(folder / "t.csv");
  EXPECT_EQ(rows_of(reader), rows);
}

TEST(Csv, RealsRoundTripBitForBitAcrossBufferBorders) {
  const testing::TempFolder folder;
  constexpr int kRows = 20000;  // some 400 kB: several read buffers
  {
    base::Random random(2, "csv", 0);
    CsvWriter table(folder / "t.csv", {"x"});
    for (int i = 0; i < kRows; ++i)
      table.cell(random.normal() * std::pow(10.0, random.uniform(-300.0, 300.0))).end_row();
    table.finish();
  }
  base::Random random(2, "csv", 0);
  CsvReader table(folder / "t.csv");
  int rows = 0;
  while (table.next()) {
    const double expected = random.normal() * std::pow(10.0, random.uniform(-300.0, 300.0));
    ASSERT_EQ(table.real(0), expected) << "row " << rows;
    ++rows;
  }
  EXPECT_EQ(rows, kRows);
}

TEST(Csv, ReadsTheRecordedDetections) {
  CsvReader table(testing::sample("brighton_beach/detections.csv"));
  EXPECT_EQ(table.column("xmin_px"), 3U);
  int rows = 0;
  double first_score = 0.0;
  while (table.next()) {
    if (rows++ == 0) first_score = table.real(table.column("score"));
  }
  EXPECT_EQ(rows, 314);
  EXPECT_EQ(first_score, 0.880);
}

}  // namespace
}  // namespace cairn::io
