// Boxes of the Brighton Beach survey: the recorded detections, and detections drawn from the labels
// with more noise. Needs the poses of support/brighton_beach.hpp.
#pragma once

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "base/random.hpp"
#include "support/brighton_beach.hpp"

namespace cairn::testing {

using CsvRow = std::map<std::string, std::string>;

inline std::vector<CsvRow> read_csv_rows(const std::filesystem::path& path) {
  std::ifstream file(path);
  if (!file) throw std::runtime_error("cannot read " + path.string());
  const auto split = [](std::string line) {
    if (!line.empty() && line.back() == '\r') line.pop_back();
    std::vector<std::string> cells;
    std::stringstream stream(line);
    for (std::string cell; std::getline(stream, cell, ',');) cells.push_back(cell);
    return cells;
  };
  std::string line;
  std::getline(file, line);
  const auto header = split(line);
  std::vector<CsvRow> rows;
  while (std::getline(file, line)) {
    const auto cells = split(line);
    CsvRow row;
    for (std::size_t i = 0; i < header.size(); ++i) row[header[i]] = i < cells.size() ? cells[i] : "";
    rows.push_back(std::move(row));
  }
  return rows;
}

// Rows of detections.csv or labels.csv as detections on images resized by `scaled`.
inline std::vector<survey::Detection> boxes_of(const survey::Survey& poses, const std::vector<CsvRow>& rows,
                                               double scaled = 1.0) {
  std::map<std::string, survey::FrameId> frame_of;
  for (const auto& frame : poses.frames) frame_of[frame.image] = frame.id;
  std::vector<survey::Detection> result;
  for (const auto& row : rows) {
    survey::Detection d;
    d.id = survey::DetectionId(static_cast<std::int64_t>(result.size()) + 1);
    d.frame = frame_of.at(row.at("image"));
    d.object_class = row.at("class");
    d.score = row.contains("score") ? std::stod(row.at("score")) : 1.0;
    d.box = {std::stod(row.at("xmin_px")) * scaled, std::stod(row.at("ymin_px")) * scaled,
             std::stod(row.at("xmax_px")) * scaled, std::stod(row.at("ymax_px")) * scaled};
    result.push_back(d);
  }
  return result;
}

inline std::vector<CsvRow> brighton_labels() {
  return read_csv_rows(test_data("brighton_beach/labels.csv"));
}
inline std::vector<CsvRow> brighton_objects() {
  return read_csv_rows(sample("brighton_beach/objects.csv"));
}

// A survey with boxes, and which object each box shows ("" = a false box, or one whose label was set aside).
struct BoxedSurvey {
  survey::Survey survey;
  std::vector<std::string> object_of;  // per detection
};

inline double box_overlap(const geometry::PixelBox& a, const geometry::PixelBox& b) {
  const double w = std::min(a.xmax, b.xmax) - std::max(a.xmin, b.xmin);
  const double h = std::min(a.ymax, b.ymax) - std::max(a.ymin, b.ymin);
  return w > 0.0 && h > 0.0 ? w * h / (a.area() + b.area() - w * h) : 0.0;
}

// detections.csv; objects by overlap with the labels (at least 0.3; the boxes moved by 3 px an edge).
inline BoxedSurvey brighton_detections(double scaled = 1.0) {
  BoxedSurvey result{brighton_beach_colmap(scaled), {}};
  result.survey.detections = boxes_of(result.survey, read_csv_rows(sample("brighton_beach/detections.csv")), scaled);
  const auto labels = brighton_labels();
  const auto label_boxes = boxes_of(result.survey, labels, scaled);
  for (const auto& d : result.survey.detections) {
    double best = 0.3;
    std::string object;
    for (std::size_t i = 0; i < labels.size(); ++i) {
      const auto& label = label_boxes[i];
      if (label.frame != d.frame || label.object_class != d.object_class) continue;
      if (const double overlap = box_overlap(label.box, d.box); overlap > best) {
        best = overlap;
        object = labels[i].at("object_id");
      }
    }
    result.object_of.push_back(object);
  }
  return result;
}

struct BoxNoise {
  double misses = 0.1;        // share of the boxes dropped
  double false_boxes = 0.05;  // false boxes added, as a share of the labels
  double edge_px = 3.0;       // 1 sigma of each edge
};

// labels.csv with noise, as detections.csv was made from all labels.
inline BoxedSurvey brighton_noisy(const BoxNoise& noise, std::uint64_t seed) {
  BoxedSurvey result{brighton_beach_colmap(1.0), {}};
  const auto labels = brighton_labels();
  const auto truth = boxes_of(result.survey, labels);
  base::Random random(seed, "brighton boxes", 0);
  const auto add = [&](survey::Detection d, const std::string& object) {
    d.id = survey::DetectionId(static_cast<std::int64_t>(result.object_of.size()) + 1);
    result.survey.detections.push_back(d);
    result.object_of.push_back(object);
  };
  for (std::size_t i = 0; i < truth.size(); ++i) {
    if (random.uniform() < noise.misses) continue;
    auto d = truth[i];
    const auto moved = [&](double edge, double limit) {
      return std::clamp(edge + noise.edge_px * random.normal(), 0.0, limit);
    };
    d.box.xmin = moved(d.box.xmin, 4000.0);
    d.box.ymin = moved(d.box.ymin, 2250.0);
    d.box.xmax = moved(d.box.xmax, 4000.0);
    d.box.ymax = moved(d.box.ymax, 2250.0);
    d.score = 0.8;
    add(d, labels[i].at("object_id"));
  }
  const auto count = static_cast<std::size_t>(noise.false_boxes * static_cast<double>(truth.size()));
  for (std::size_t i = 0; i < count; ++i) {
    auto d = truth[random.below(truth.size())];
    const double width = d.box.width(), height = d.box.height();
    d.frame = result.survey.frames[random.below(result.survey.frames.size())].id;
    const double x = random.uniform(0.0, 4000.0 - width), y = random.uniform(0.0, 2250.0 - height);
    d.box = {x, y, x + width, y + height};
    d.score = 0.4;
    add(d, "");
  }
  return result;
}

}  // namespace cairn::testing
