#include "report/html_text.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "base/number_text.hpp"

namespace cairn::report {
namespace {

// Length of the UTF-8 sequence at the start of `s`, 0 where it is malformed (RFC 3629).
std::size_t sequence_length(std::string_view s) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(s[i]); };
  const unsigned char lead = byte(0);
  if (lead < 0x80) return 1;
  const std::size_t n = lead >= 0xF0 && lead <= 0xF4 ? 4 : lead >= 0xE0 ? 3 : lead >= 0xC2 ? 2 : 0;
  if (n == 0 || lead > 0xF4 || s.size() < n) return 0;
  for (std::size_t i = 1; i < n; ++i)
    if ((byte(i) & 0xC0) != 0x80) return 0;
  if (lead == 0xE0 && byte(1) < 0xA0) return 0;
  if (lead == 0xED && byte(1) > 0x9F) return 0;
  if (lead == 0xF0 && byte(1) < 0x90) return 0;
  if (lead == 0xF4 && byte(1) > 0x8F) return 0;
  return n;
}

}  // namespace

std::string clean_utf8(std::string_view text) {
  std::string out;
  out.reserve(text.size());
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t n = sequence_length(text.substr(i));
    if (n == 0) {
      out += "\xEF\xBF\xBD";
      ++i;
      continue;
    }
    const auto c = static_cast<unsigned char>(text[i]);
    const bool control = n == 1 && ((c < 0x20 && c != '\t' && c != '\n') || c == 0x7F);
    // U+202A..U+202E and U+2066..U+2069 turn the order of the text around them.
    const auto third = n == 3 ? static_cast<unsigned char>(text[i + 2]) : 0;
    const bool turning = n == 3 && c == 0xE2 &&
                         ((text[i + 1] == '\x80' && third >= 0xAA && third <= 0xAE) ||
                          (text[i + 1] == '\x81' && third >= 0xA6 && third <= 0xA9));
    if (!control && !turning) out.append(text.substr(i, n));
    i += n;
  }
  return out;
}

std::string escape_html(std::string_view text) {
  const std::string clean = clean_utf8(text);
  std::string out;
  out.reserve(clean.size() + clean.size() / 8);
  for (const char c : clean) {
    switch (c) {
      case '&': out += "&amp;"; break;
      case '<': out += "&lt;"; break;
      case '>': out += "&gt;"; break;
      case '"': out += "&quot;"; break;
      case '\'': out += "&#39;"; break;
      default: out += c;
    }
  }
  return out;
}

std::string script_safe(std::string_view json) {
  std::string out;
  out.reserve(json.size() + 64);
  for (std::size_t i = 0; i < json.size(); ++i) {
    const char c = json[i];
    if (c == '<') {
      out += "\\u003c";
    } else if (c == '>') {
      out += "\\u003e";
    } else if (c == '&') {
      out += "\\u0026";
    } else if (json.substr(i, 2) == "\xE2\x80" && i + 2 < json.size() &&
               (json[i + 2] == '\xA8' || json[i + 2] == '\xA9')) {
      out += json[i + 2] == '\xA8' ? "\\u2028" : "\\u2029";
      i += 2;
    } else {
      out += c;
    }
  }
  return out;
}

Html& Html::symbol(std::string_view words) {
  const std::size_t mark = words.find('_');
  if (mark == std::string_view::npos) return text(words);
  const std::size_t end = std::min(words.find(' ', mark), words.size());
  return text(words.substr(0, mark))
      .raw("<sub>")
      .text(words.substr(mark + 1, end - mark - 1))
      .raw("</sub>")
      .text(words.substr(end));
}

std::string Html::short_number(double value, int decimals) {
  if (!std::isfinite(value)) return "0";
  std::string text = base::to_fixed(value, decimals);
  if (text.find('.') != std::string::npos) {
    while (text.back() == '0') text.pop_back();
    if (text.back() == '.') text.pop_back();
  }
  return text == "-0" ? "0" : text;
}

}  // namespace cairn::report
