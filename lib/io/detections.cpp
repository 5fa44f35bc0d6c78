#include "io/detections.hpp"

#include <algorithm>
#include <array>
#include <numeric>
#include <utility>

#include "base/error.hpp"
#include "base/number_text.hpp"
#include "io/box_readers.hpp"
#include "io/bytes.hpp"

namespace cairn::io {
namespace fs = std::filesystem;
namespace {

using base::Error;
using base::ErrorCode;
using Reader = BoxFile (*)(const fs::path&, const ReadBoxesOptions&);

struct Format {
  BoxFormat format;
  std::string_view name;
  Reader read;
};

constexpr std::array<Format, 8> kFormats{{{BoxFormat::mot, "mot", boxes::read_mot},
                                          {BoxFormat::coco, "coco", boxes::read_coco},
                                          {BoxFormat::yolo, "yolo", boxes::read_yolo},
                                          {BoxFormat::voc, "voc", boxes::read_voc},
                                          {BoxFormat::cvat, "cvat", boxes::read_cvat},
                                          {BoxFormat::darknet_json, "darknet-json", boxes::read_darknet_json},
                                          {BoxFormat::darknet_txt, "darknet-txt", boxes::read_darknet_txt},
                                          {BoxFormat::survey_csv, "csv", boxes::read_survey_csv}}};

std::string allowed_formats() {
  std::string text;
  for (const auto& f : kFormats) text += (text.empty() ? "" : ", ") + std::string(f.name);
  return text;
}

// Digits compare by their value: img2 < img10.
bool natural_less(std::string_view a, std::string_view b) {
  const auto digit = [](char c) { return c >= '0' && c <= '9'; };
  std::size_t i = 0, k = 0;
  while (i < a.size() && k < b.size()) {
    if (digit(a[i]) && digit(b[k])) {
      std::size_t ia = i, kb = k;
      while (ia < a.size() && a[ia] == '0') ++ia;
      while (kb < b.size() && b[kb] == '0') ++kb;
      std::size_t ea = ia, eb = kb;
      while (ea < a.size() && digit(a[ea])) ++ea;
      while (eb < b.size() && digit(b[eb])) ++eb;
      if (ea - ia != eb - kb) return ea - ia < eb - kb;
      const int order = a.substr(ia, ea - ia).compare(b.substr(kb, eb - kb));
      if (order != 0) return order < 0;
      i = ea;
      k = eb;
      continue;
    }
    if (a[i] != b[k]) return a[i] < b[k];
    ++i;
    ++k;
  }
  if ((i < a.size()) != (k < b.size())) return k < b.size();
  return a < b;
}

}  // namespace

std::string_view name_of(BoxFormat format) {
  for (const auto& f : kFormats)
    if (f.format == format) return f.name;
  return "unknown";
}

const std::vector<std::string>& box_format_names() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> list;
    for (const auto& f : kFormats) list.emplace_back(f.name);
    return list;
  }();
  return names;
}

BoxFormat box_format_from(std::string_view name) {
  for (const auto& f : kFormats)
    if (f.name == name) return f.format;
  throw Error(ErrorCode::invalid_argument, "unknown format of boxes")
      .found("'" + std::string(name) + "'")
      .allowed(allowed_formats());
}

BoxFile read_boxes(const fs::path& path, BoxFormat format, const ReadBoxesOptions& options) {
  for (const auto& f : kFormats)
    if (f.format == format) return f.read(path, options);
  throw Error(ErrorCode::internal, "format of boxes without a reader");
}

std::vector<std::string> read_class_names(const fs::path& path) {
  const FileBytes bytes(path);
  TextReader reader(bytes.text(), bytes.name());
  std::vector<std::string> names;
  while (const auto line = reader.next_line()) names.emplace_back(base::trim(*line));
  while (!names.empty() && names.back().empty()) names.pop_back();
  if (names.empty())
    throw Error(ErrorCode::invalid_input, "no class names").file(path.string()).allowed("one name a line");
  return names;
}

namespace boxes {

void order_images(BoxFile& file) {
  const bool numbered =
      std::all_of(file.images.begin(), file.images.end(), [](const auto& i) { return i.number >= 0; });
  std::vector<std::size_t> order(file.images.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  const auto less = [&](std::size_t a, std::size_t b) {
    const BoxImage &x = file.images[a], &y = file.images[b];
    if (numbered || file.format == BoxFormat::mot) return x.number < y.number;
    return natural_less(x.name, y.name);
  };
  if (std::is_sorted(order.begin(), order.end(), less)) return;
  std::stable_sort(order.begin(), order.end(), less);
  std::vector<std::size_t> rank(order.size());
  std::vector<BoxImage> images;
  images.reserve(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    rank[order[i]] = i;
    images.push_back(std::move(file.images[order[i]]));
  }
  file.images = std::move(images);
  for (auto& box : file.boxes) box.image = rank[box.image];
}

}  // namespace boxes

}  // namespace cairn::io
