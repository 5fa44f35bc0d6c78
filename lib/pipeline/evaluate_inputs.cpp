#include "pipeline/evaluate_inputs.hpp"

#include "base/error.hpp"
#include "base/number_text.hpp"

namespace cairn::pipeline {
namespace fs = std::filesystem;

using io::Json;

std::optional<fs::path> truth_json(const fs::path& path) {
  if (fs::is_directory(path)) {
    const auto inside = path / "truth.json";
    return fs::exists(inside) ? std::optional(inside) : std::nullopt;
  }
  return path.filename() == "truth.json" ? std::optional(path) : std::nullopt;
}

void require_path(const fs::path& path, const char* what) {
  if (path.empty())
    throw base::Error(base::ErrorCode::invalid_argument, std::string(what) + " is not given")
        .hint("Name it with --truth");
  if (!fs::exists(path))
    throw base::Error(base::ErrorCode::not_found, std::string(what) + " does not exist").file(path.string());
}

std::set<std::string> class_list(const std::string& text) {
  std::set<std::string> names;
  std::size_t begin = 0;
  while (begin <= text.size()) {
    const auto end = std::min(text.find(',', begin), text.size());
    const auto name = base::trim(std::string_view(text).substr(begin, end - begin));
    if (!name.empty()) names.emplace(name);
    begin = end + 1;
  }
  return names;
}

std::set<std::string> scored_classes(const survey::Truth& truth, const std::string& classes) {
  auto names = class_list(classes);
  if (names.empty())
    for (const auto& object : truth.objects)
      if (object.sought) names.insert(object.object_class);
  return names;
}

io::BoxFile read_box_file(const fs::path& path, const std::string& format,
                          const std::vector<std::string>& class_names) {
  const auto known = format == "auto" ? io::recognise_boxes(path) : io::box_format_from(format);
  return io::read_boxes(path, known, {class_names, {}, false});
}

Json to_json(const evaluation::Spread& s, const std::string& suffix) {
  const auto figure = [&](double value) { return s.count == 0 ? Json() : Json(value); };
  return Json::object({{"count", s.count},
                       {"mean" + suffix, figure(s.mean)},
                       {"rmse" + suffix, figure(s.rms)},
                       {"median" + suffix, figure(s.median)},
                       {"p95" + suffix, figure(s.p95)},
                       {"max" + suffix, figure(s.max)}});
}

Json optional_json(const std::optional<double>& value) {
  return value ? Json(*value) : Json();
}

}  // namespace cairn::pipeline
