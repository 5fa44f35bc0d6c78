#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "io/edits_csv.hpp"
#include "io/field_notes.hpp"
#include "support/data.hpp"

namespace cairn::io {
namespace {

using cairn::testing::TempFolder;
using ::testing::HasSubstr;

TEST(Utc, ReadsIso8601) {
  constexpr std::int64_t kDay_ns = 86'400'000'000'000;
  EXPECT_EQ(parse_utc_ns("1970-01-02"), kDay_ns);
  EXPECT_EQ(parse_utc_ns("1970-01-02T00:00Z"), kDay_ns);
  EXPECT_EQ(parse_utc_ns("1970-01-02 00:00:01.5"), kDay_ns + 1'500'000'000);
  EXPECT_EQ(parse_utc_ns("1970-01-02T02:00:00+02:00"), kDay_ns);
  EXPECT_EQ(parse_utc_ns("1970-01-01T23:30:00-00:30"), kDay_ns);
  for (const char* bad : {"", "yesterday", "2026-13-01", "2026-01-01T25:00", "2026-01-01T10", "2026-1-1", "01.02.2026",
                          "2026-01-01T10:00:xx", "2026-01-01T10:00:00+99:00", "2026-01-01T10:00:00 UTC"})
    EXPECT_FALSE(parse_utc_ns(bad)) << bad;
}

TEST(EditsCsv, ReadsBackWhatItWrites) {
  const TempFolder folder;
  std::vector<survey::Edit> edits(2);
  edits[0] = {2, "7", survey::EditAction::merge, "8;9", "one, broken \"rock\"", "ada", "2026-05-01T10:00:00Z", 0};
  edits[1] = {3, "site-0007", survey::EditAction::note, "-- leaning", "", "bob", "2026-05-01T10:00:00Z", 0};
  for (auto& e : edits) e.time_ns = *parse_utc_ns(e.time);
  write_edits(folder / "edits.csv", edits);
  const auto back = read_edits(folder / "edits.csv");
  ASSERT_EQ(back.size(), 2U);
  EXPECT_EQ(back[0], edits[0]);
  EXPECT_EQ(back[0].line, 2U);
  EXPECT_EQ(back[1].rock_id, "site-0007");
}

TEST(EditsCsv, RefusesOtherColumns) {
  const TempFolder folder;
  base::write_file(folder / "edits.csv", "rock_id,action,value,reason,operator,time,confidence\n");
  EXPECT_THROW((void)read_edits(folder / "edits.csv"), base::Error);
  base::write_file(folder / "edits.csv", "rock_id,action,value,reason,time\n");
  EXPECT_THROW((void)read_edits(folder / "edits.csv"), base::Error);
}

TEST(FieldNotes, KeepsColumnsUnderPlainNames) {
  const TempFolder folder;
  base::write_file(folder / "notes.csv",
                   "Rock ID,Lat,Lon,observed_utc,Soil depth (cm)\n12,,,2026-05-01T10:00:00Z,30\n,46.5,-92.25,,\n");
  const auto file = read_field_notes(folder / "notes.csv");
  ASSERT_EQ(file.notes.size(), 2U);
  EXPECT_THAT(file.columns, ::testing::ElementsAre("soil_depth__cm_"));
  EXPECT_EQ(file.notes[0].id, "12");
  EXPECT_EQ(file.notes[0].observed_ns, parse_utc_ns("2026-05-01T10:00:00Z"));
  EXPECT_EQ(file.notes[0].values.at(0).second, "30");
  EXPECT_EQ(file.notes[1].longitude_deg, -92.25);
  EXPECT_TRUE(file.notes[1].values.empty());
  base::write_file(folder / "twice.csv", "id,rock_id\n1,2\n");
  EXPECT_THROW((void)read_field_notes(folder / "twice.csv"), base::Error);
  base::write_file(folder / "off.csv", "latitude,longitude\n91,0\n");
  EXPECT_THROW((void)read_field_notes(folder / "off.csv"), base::Error);
}

}  // namespace
}  // namespace cairn::io
