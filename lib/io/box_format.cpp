#include <algorithm>
#include <fstream>
#include <string>

#include "base/error.hpp"
#include "base/number_text.hpp"
#include "io/bytes.hpp"
#include "io/detections.hpp"

namespace cairn::io {
namespace fs = std::filesystem;
namespace {

using base::Error;
using base::ErrorCode;

constexpr std::size_t kLook = std::size_t{1} << 16U;  // bytes looked at

std::string beginning(const fs::path& path) {
  const InputFile file(path);
  std::string text(static_cast<std::size_t>(std::min<std::uint64_t>(file.size(), kLook)), '\0');
  file.read_at(0, std::as_writable_bytes(std::span(text.data(), text.size())));
  return text;
}

Error unknown(const fs::path& path, std::string found) {
  std::string names;
  for (const auto& name : box_format_names()) names += (names.empty() ? "" : ", ") + name;
  return Error(ErrorCode::invalid_input, "format of the boxes not recognised")
      .file(path.string())
      .found(std::move(found))
      .allowed(names)
      .hint("Name the format with --format (in import: --detections-format)");
}

BoxFormat recognise_folder(const fs::path& folder) {
  bool xml = false, txt = false;
  for (const auto& entry : fs::directory_iterator(folder)) {
    xml = xml || entry.path().extension() == ".xml";
    txt = txt || entry.path().extension() == ".txt";
  }
  if (xml == txt) throw unknown(folder, xml ? "both .xml and .txt files" : "neither .xml nor .txt files");
  return xml ? BoxFormat::voc : BoxFormat::yolo;
}

BoxFormat recognise_lines(const fs::path& path, std::string_view text) {
  if (text.find("(left_x:") != std::string_view::npos || text.find(": Predicted in ") != std::string_view::npos)
    return BoxFormat::darknet_txt;
  TextReader reader(text, path.string());
  while (const auto line = reader.next_line()) {
    const std::string_view row = base::trim(*line);
    if (row.empty() || row.front() == '#') continue;
    if (row.find("xmin_px") != std::string_view::npos) return BoxFormat::survey_csv;
    if (row.find(',') != std::string_view::npos) {
      if (std::count(row.begin(), row.end(), ',') >= 5 && parse_number(row.substr(0, row.find(','))))
        return BoxFormat::mot;
    } else {
      std::string_view rest = row;
      std::size_t count = 0, numbers = 0;
      for (auto word = take_word(rest); !word.empty(); word = take_word(rest)) {
        ++count;
        if (parse_number(word)) ++numbers;
      }
      if (numbers == count && (count == 5 || count == 6)) return BoxFormat::yolo;
      if (numbers == count && count > 6) return BoxFormat::mot;
    }
    throw unknown(path, "line " + std::to_string(reader.line()) + ": '" + std::string(row.substr(0, 60)) + "'");
  }
  // Nothing was detected: an empty file is what most tools then write.
  return path.extension() == ".txt" ? BoxFormat::mot : throw unknown(path, "no rows");
}

}  // namespace

BoxFormat recognise_boxes(const fs::path& path) {
  std::error_code code;
  if (!fs::exists(path, code))
    throw Error(ErrorCode::not_found, "no such file of boxes").file(path.string()).hint("Check the path");
  if (fs::is_directory(path, code)) return recognise_folder(path);
  const std::string text = beginning(path);
  std::string_view look = text;
  if (look.starts_with("\xEF\xBB\xBF")) look.remove_prefix(3);
  look = base::trim(look);
  if (look.starts_with('<')) {
    if (look.find("<annotations") != std::string_view::npos) return BoxFormat::cvat;
    if (look.find("<annotation") != std::string_view::npos) return BoxFormat::voc;
    throw unknown(path, "XML without <annotation> or <annotations>");
  }
  if (look.starts_with('[') || look.starts_with('{')) {
    const bool darknet = look.find("\"relative_coordinates\"") != std::string_view::npos ||
                         look.find("\"objects\"") != std::string_view::npos;
    return darknet ? BoxFormat::darknet_json : BoxFormat::coco;
  }
  return recognise_lines(path, look);
}

}  // namespace cairn::io
