#include "report/html_text.hpp"

#include <gtest/gtest.h>

namespace cairn::report {
namespace {

TEST(EscapeHtml, turns_markup_into_entities) {
  EXPECT_EQ(escape_html("<a href=\"x\">O'Neil & co</a>"), "&lt;a href=&quot;x&quot;&gt;O&#39;Neil &amp; co&lt;/a&gt;");
}

TEST(EscapeHtml, keeps_utf8_and_replaces_what_is_not) {
  EXPECT_EQ(escape_html("Grüße α 岩"), "Grüße α 岩");
  EXPECT_EQ(escape_html("a\xC3(b"), "a\xEF\xBF\xBD(b");
  EXPECT_EQ(escape_html("\xFF"), "\xEF\xBF\xBD");
  // An overlong slash, a surrogate, and a code point past U+10FFFF are not UTF-8.
  EXPECT_EQ(escape_html("\xC0\xAF").find('/'), std::string::npos);
  EXPECT_EQ(escape_html("\xED\xA0\x80"), "\xEF\xBF\xBD\xEF\xBF\xBD\xEF\xBF\xBD");
  EXPECT_EQ(escape_html("\xF4\x90\x80\x80").substr(0, 3), "\xEF\xBF\xBD");
  EXPECT_EQ(escape_html("cut \xE2\x80"), "cut \xEF\xBF\xBD\xEF\xBF\xBD");
}

TEST(EscapeHtml, drops_control_and_text_turning_characters) {
  EXPECT_EQ(escape_html(std::string("a\0b\x1B[31mc\x7F", 10)), "ab[31mc");
  EXPECT_EQ(escape_html("photo\xE2\x80\xAEgpj.exe"), "photogpj.exe");
  EXPECT_EQ(escape_html("x\xE2\x81\xA6y"), "xy");
  EXPECT_EQ(escape_html("en\xE2\x80\x93"
                        "dash"),
            "en\xE2\x80\x93"
            "dash");
}

TEST(ScriptSafe, leaves_no_way_out_of_a_script_element) {
  const std::string safe = script_safe(R"({"a":"</script><!--","b":"&amp;"})");
  EXPECT_EQ(safe.find_first_of("<>&"), std::string::npos);
  EXPECT_EQ(safe, R"({"a":"\u003c/script\u003e\u003c!--","b":"\u0026amp;"})");
  EXPECT_EQ(script_safe("\xE2\x80\xA8\xE2\x80\xA9"), "\\u2028\\u2029");
}

TEST(Html, escapes_attributes_and_shortens_numbers) {
  Html h;
  h.raw("<p").attr("title", "a\"b").attr("x", 1.5).attr("y", -0.0001, 3).raw(">");
  EXPECT_EQ(h.str(), "<p title=\"a&quot;b\" x=\"1.5\" y=\"0\">");
  EXPECT_EQ(Html::short_number(120.0, 2), "120");
  EXPECT_EQ(Html::short_number(std::numeric_limits<double>::quiet_NaN(), 2), "0");
}

TEST(Html, sets_subscripts) {
  Html h;
  h.symbol("a_qs there").symbol(" plain").symbol("v_min<");
  EXPECT_EQ(h.str(), "a<sub>qs</sub> there plainv<sub>min&lt;</sub>");
}

}  // namespace
}  // namespace cairn::report
