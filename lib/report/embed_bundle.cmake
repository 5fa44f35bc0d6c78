# Writes a C++ source that holds the bundled script and style sheet as strings.
#   cmake -DSCRIPT=report.js -DSTYLE=report.css -DOUTPUT=web_bundle.cpp -P embed_bundle.cmake
# Compilers take string literals of limited length, so each text is cut into pieces.
function(literal_pieces FILE VARIABLE)
  file(READ "${FILE}" _hex HEX)
  string(TOLOWER "${_hex}" _check)
  # "</script" and "</style" would end the element that the text stands in.
  if(_check MATCHES "3c2f736372697074" OR _check MATCHES "3c2f7374796c65")
    file(READ "${FILE}" _text)
    string(TOLOWER "${_text}" _text)
    if(_text MATCHES "</script" OR _text MATCHES "</style")
      message(FATAL_ERROR "${FILE} holds a closing tag that would end its own element")
    endif()
  endif()
  string(REGEX REPLACE "(..)" "0x\\1," _bytes "${_hex}")
  set(${VARIABLE} "${_bytes}" PARENT_SCOPE)
endfunction()

literal_pieces("${SCRIPT}" _script)
literal_pieces("${STYLE}" _style)
file(WRITE "${OUTPUT}" "// Generated from lib/report/web.
#include \"report/web_bundle.hpp\"

namespace cairn::report {
namespace {
constexpr unsigned char kScript[] = {${_script}0};
constexpr unsigned char kStyle[] = {${_style}0};
}  // namespace
std::string_view bundle_script() { return {reinterpret_cast<const char*>(kScript), sizeof(kScript) - 1}; }
std::string_view bundle_style() { return {reinterpret_cast<const char*>(kStyle), sizeof(kStyle) - 1}; }
}  // namespace cairn::report
")
