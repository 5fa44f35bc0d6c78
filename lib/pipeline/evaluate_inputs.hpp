// What the parts of stage `evaluate` share: where truth lies, and figures as JSON.
#pragma once

#include <filesystem>
#include <optional>
#include <set>
#include <string>

#include "evaluation/statistics.hpp"
#include "io/detections.hpp"
#include "io/json.hpp"
#include "pipeline/evaluate_stage.hpp"
#include "survey/truth.hpp"

namespace cairn::pipeline {

// The truth.json that `path` is, or that lies in the folder `path`; empty where there is none.
[[nodiscard]] std::optional<std::filesystem::path> truth_json(const std::filesystem::path& path);

// Throws not_found where `path` does not exist.
void require_path(const std::filesystem::path& path, const char* what);

// Comma-separated names; blanks around them are dropped.
[[nodiscard]] std::set<std::string> class_list(const std::string& text);

// Classes of the objects a simulated survey was flown for, or those of --classes.
[[nodiscard]] std::set<std::string> scored_classes(const survey::Truth& truth, const std::string& classes);

// A file or folder of boxes in the format given or recognised.
[[nodiscard]] io::BoxFile read_box_file(const std::filesystem::path& path, const std::string& format,
                                        const std::vector<std::string>& class_names);

// {count, mean, rmse, median, p95, max}, each name but count with the suffix ("_m"); figures null where count is 0.
[[nodiscard]] io::Json to_json(const evaluation::Spread& spread, const std::string& suffix = "");
[[nodiscard]] io::Json optional_json(const std::optional<double>& value);

}  // namespace cairn::pipeline
