// Building HTML so that text from a survey can never become markup.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace cairn::report {

// UTF-8 with &, <, >, ", ' as entities; control characters (tab and line end apart) dropped;
// bytes that are not UTF-8 replaced by U+FFFD.
[[nodiscard]] std::string escape_html(std::string_view text);

// The same cleaning without entities, for text that goes into JSON.
[[nodiscard]] std::string clean_utf8(std::string_view text);

// JSON text that may stand inside a <script> element: no '<', '>' or '&' and no U+2028, U+2029 is left.
[[nodiscard]] std::string script_safe(std::string_view json);

// A piece of markup. Markup comes from string literals only, everything else is escaped.
class Html {
 public:
  template <std::size_t N>
  Html& raw(const char (&markup)[N]) {
    out_.append(markup, N - 1);
    return *this;
  }
  Html& text(std::string_view text) {
    out_ += escape_html(text);
    return *this;
  }
  // The same, with "a_qs" set as a with the subscript qs.
  Html& symbol(std::string_view text);
  // ` name="value"`, value escaped.
  template <std::size_t N>
  Html& attr(const char (&name)[N], std::string_view value) {
    out_ += ' ';
    out_.append(name, N - 1);
    out_ += "=\"";
    out_ += escape_html(value);
    out_ += '"';
    return *this;
  }
  // Number with at most `decimals` decimals, trailing zeros dropped.
  template <std::size_t N>
  Html& attr(const char (&name)[N], double value, int decimals = 3) {
    return attr(name, short_number(value, decimals));
  }
  Html& add(const Html& other) {
    out_ += other.out_;
    return *this;
  }
  // Bytes this program made itself (base64, its own bundle): inserted as they are.
  Html& made(std::string_view own_bytes) {
    out_ += own_bytes;
    return *this;
  }
  [[nodiscard]] bool empty() const { return out_.empty(); }
  [[nodiscard]] const std::string& str() const& { return out_; }
  [[nodiscard]] std::string str() && { return std::move(out_); }

  [[nodiscard]] static std::string short_number(double value, int decimals);

 private:
  std::string out_;
};

}  // namespace cairn::report
