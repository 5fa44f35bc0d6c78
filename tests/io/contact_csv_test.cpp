#include "io/contact_csv.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "support/data.hpp"

namespace cairn::io {
namespace {

constexpr const char* kHeader = "rock_id,pad_id,order,x,y,z,status,sigma_m,closed\n";

class ContactCsv : public ::testing::Test {
 protected:
  testing::TempFolder folder_;
  ContactFile read(const std::string& text) {
    base::write_file(folder_ / "contact.csv", text);
    return read_contact_csv(folder_ / "contact.csv");
  }
  std::string refusal(const std::string& row) {
    try {
      (void)read(kHeader + row);
    } catch (const base::Error& error) {
      EXPECT_EQ(error.code(), base::ErrorCode::invalid_input);
      return error.what();
    }
    return "accepted";
  }
};

TEST_F(ContactCsv, RowsAndFrame) {
  const auto file =
      read(std::string("# crs: local\n") + kHeader + "4,0,0,1.5,-2,0.25,observed,0.01,1\n4,0,1,2,3,0,inferred,,0\n");
  EXPECT_EQ(file.crs, "local");
  ASSERT_EQ(file.rows.size(), 2U);
  EXPECT_EQ(file.rows[0].rock_id, 4);
  EXPECT_EQ(file.rows[0].vertex.position, geometry::Vec3(1.5, -2, 0.25));
  EXPECT_TRUE(file.rows[0].vertex.observed);
  EXPECT_TRUE(file.rows[0].vertex.closed);
  EXPECT_EQ(file.rows[0].vertex.sigma_m, 0.01);
  EXPECT_FALSE(file.rows[1].vertex.observed);
  EXPECT_FALSE(file.rows[1].vertex.closed);
  EXPECT_EQ(read(kHeader).crs, "");
}

TEST_F(ContactCsv, WritesWhatItReads) {
  const std::string row = "4,1,2,0.1,-2,1e-09,inferred,0.015,0\n";
  const auto file = read(std::string("# crs: EPSG:32612\n") + kHeader + row);
  write_contact_csv(folder_ / "again.csv", file);
  EXPECT_EQ(base::read_file(folder_ / "again.csv"), std::string("# crs: EPSG:32612\n") + kHeader + row);
}

TEST_F(ContactCsv, RefusesWithLineAndColumn) {
  using ::testing::HasSubstr;
  EXPECT_THAT(refusal("4,0,0,1,2,3,seen,,1\n"), HasSubstr("observed, inferred"));
  EXPECT_THAT(refusal("4,0,0,1,nan,3,observed,,1\n"), HasSubstr("line 2"));
  EXPECT_THAT(refusal("4,0,0,1,2,3,observed,-1,1\n"), HasSubstr("sigma"));
  EXPECT_THAT(refusal("4,0,0,1,2,3,observed,,2\n"), HasSubstr("closed"));
  EXPECT_THAT(refusal("4,0,7,1,2,3,observed,,1\n4,0,7,1,2,4,observed,,1\n"), HasSubstr("taken already"));
  EXPECT_THAT(refusal("4,0,0,1,2\n"), HasSubstr("line 2"));
}

}  // namespace
}  // namespace cairn::io
