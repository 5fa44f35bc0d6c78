#include "io/json.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "base/error.hpp"

namespace cairn::io {
namespace {

using ::testing::HasSubstr;

std::string message_of(std::string_view text) {
  try {
    (void)parse_json(text, "f.json");
  } catch (const base::Error& e) {
    EXPECT_EQ(e.code(), base::ErrorCode::invalid_input);
    return e.what();
  }
  ADD_FAILURE() << "accepted: " << text;
  return "";
}

TEST(Json, RoundTripsTextExactly) {
  const std::string text = R"({"b":[1,2.5,-0.1,1e-7],"a":{"n":null,"t":true,"s":"\u00e4\"\\\n"}})";
  const Json value = parse_json(text, "x");
  EXPECT_EQ(parse_json(value.dump(0), "x"), value);
  EXPECT_EQ(parse_json(value.dump(2), "x"), value);
  EXPECT_EQ(value.as_object()[0].first, "b");
}

TEST(Json, RealsStayReals) {
  EXPECT_EQ(Json(2.0).dump(0), "2.0");
  EXPECT_EQ(Json(2).dump(0), "2");
  EXPECT_EQ(Json(-0.0).dump(0), "0.0");
  EXPECT_TRUE(Json(std::nan("")).is_null());
}

TEST(Json, RefusesWithPlace) {
  EXPECT_THAT(message_of("{\"a\": 1,\n \"a\": 2}"), HasSubstr("key 'a' appears twice"));
  EXPECT_THAT(message_of("{\"a\":\n\n  }"), HasSubstr("line 3"));
  EXPECT_THAT(message_of("[1] x"), HasSubstr("not valid JSON"));
  EXPECT_THAT(message_of("[NaN]"), HasSubstr("not valid JSON"));
  EXPECT_THAT(message_of("[1e999]"), HasSubstr("out of range"));
  EXPECT_THAT(message_of(std::string(100, '[')), HasSubstr("nested deeper"));
  EXPECT_THAT(message_of(""), HasSubstr("not valid JSON"));
}

TEST(Json, WrongKindsAreNamed) {
  const Json value = parse_json(R"({"a": "x", "v": [1, 2]})", "x");
  EXPECT_THROW((void)value.at("a").as_real(), base::Error);
  EXPECT_THROW((void)value.at("v").as_vec3(), base::Error);
  EXPECT_THROW((void)value.at("missing"), base::Error);
  EXPECT_EQ(value.find("missing"), nullptr);
}

}  // namespace
}  // namespace cairn::io
