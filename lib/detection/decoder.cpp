#include "detection/decoder.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "base/error.hpp"

namespace cairn::detection {
namespace {

using base::Error;
using base::ErrorCode;
using geometry::PixelBox;

constexpr std::array<std::pair<Decoder, std::string_view>, 7> kNames{{{Decoder::yolo_v5, "yolo-v5"},
                                                                      {Decoder::yolo_v8, "yolo-v8"},
                                                                      {Decoder::end_to_end, "end-to-end"},
                                                                      {Decoder::yolox, "yolox"},
                                                                      {Decoder::darknet, "darknet"},
                                                                      {Decoder::scored_boxes, "scored-boxes"},
                                                                      {Decoder::yunet, "yunet"}}};
constexpr std::array<std::size_t, 3> kStrides{8, 16, 32};
constexpr std::size_t kEndToEndRows = 1000;  // networks that suppress keep a few hundred boxes

std::vector<TensorShape> shapes_of(std::span<const Tensor> outputs) {
  std::vector<TensorShape> shapes;
  for (const auto& t : outputs) shapes.push_back(t.shape);
  return shapes;
}

Error unfit(const std::vector<TensorShape>& outputs, const std::string& message, const std::string& allowed) {
  return Error(ErrorCode::invalid_input, message).found("outputs " + describe(outputs)).allowed(allowed);
}

constexpr const char* kKnown =
    "[1,N,5+C] (yolo-v5, yolox), [1,4+C,N] (yolo-v8), [1,N,6] (end-to-end), [N,5+C] (darknet), [1,N,C] with [1,N,4] "
    "(scored-boxes), cls/obj/bbox of strides 8, 16, 32 (yunet)";

bool batched(const TensorShape& s) {
  return s.dims.size() == 3 && s.dims[0] == 1;
}

const Tensor* named(std::span<const Tensor> outputs, const std::string& name) {
  for (const auto& t : outputs)
    if (t.shape.name == name) return &t;
  return nullptr;
}
bool has(const std::vector<TensorShape>& outputs, const std::string& name) {
  return std::any_of(outputs.begin(), outputs.end(), [&](const auto& s) { return s.name == name; });
}

bool yunet_names(const std::vector<TensorShape>& outputs) {
  for (const std::size_t s : kStrides)
    for (const auto* part : {"cls_", "obj_", "bbox_"})
      if (!has(outputs, part + std::to_string(s))) return false;
  return true;
}

// The pair of scored_boxes: index of the scores, of the corners.
std::optional<std::pair<std::size_t, std::size_t>> scored_pair(const std::vector<TensorShape>& outputs) {
  if (outputs.size() != 2 || !batched(outputs[0]) || !batched(outputs[1])) return std::nullopt;
  if (outputs[0].dims[1] != outputs[1].dims[1]) return std::nullopt;
  for (const std::size_t corners : {std::size_t{0}, std::size_t{1}}) {
    if (outputs[corners].dims[2] != 4) continue;
    // Four classes look like corners: then the name decides.
    if (outputs[1 - corners].dims[2] == 4 && outputs[corners].name.find("box") == std::string::npos) continue;
    return std::pair{1 - corners, corners};
  }
  return std::nullopt;
}

ScoredBox from_centre(double x, double y, double w, double h, std::size_t object_class, double score) {
  return {{x - 0.5 * w, y - 0.5 * h, x + 0.5 * w, y + 0.5 * h}, object_class, score};
}

class Collector {
 public:
  explicit Collector(double min_score) : min_score_(min_score) {}
  void add(const ScoredBox& box) {
    if (!(box.score >= min_score_)) return;
    for (const double side : {box.box.xmin, box.box.ymin, box.box.xmax, box.box.ymax})
      if (!std::isfinite(side)) return;
    if (!(box.box.width() > 0.0 && box.box.height() > 0.0)) return;
    boxes.push_back(box);
    boxes.back().score = std::min(box.score, 1.0);
  }
  std::vector<ScoredBox> boxes;

 private:
  double min_score_;
};

// Best of `count` scores, `step` apart; the first of equal ones.
std::pair<std::size_t, double> best_class(const float* scores, std::size_t count, std::size_t step = 1) {
  std::size_t best = 0;
  for (std::size_t c = 1; c < count; ++c)
    if (scores[c * step] > scores[best * step]) best = c;
  return {best, static_cast<double>(scores[best * step])};
}

void decode_yolo_v5(const Tensor& t, Collector& out) {
  const std::size_t rows = t.shape.dims[1], columns = t.shape.dims[2];
  for (std::size_t r = 0; r < rows; ++r) {
    const float* v = t.values.data() + r * columns;
    const auto [c, score] = best_class(v + 5, columns - 5);
    out.add(from_centre(v[0], v[1], v[2], v[3], c, score * static_cast<double>(v[4])));
  }
}

void decode_yolo_v8(const Tensor& t, Collector& out) {
  const std::size_t rows = t.shape.dims[1], n = t.shape.dims[2];
  for (std::size_t i = 0; i < n; ++i) {
    const float* v = t.values.data() + i;
    const auto [c, score] = best_class(v + 4 * n, rows - 4, n);
    out.add(from_centre(v[0], v[n], v[2 * n], v[3 * n], c, score));
  }
}

void decode_end_to_end(const Tensor& t, Collector& out) {
  for (std::size_t r = 0; r < t.shape.dims[1]; ++r) {
    const float* v = t.values.data() + r * 6;
    if (!(v[5] >= 0.0F && v[5] < 1e6F)) continue;
    out.add({{v[0], v[1], v[2], v[3]}, static_cast<std::size_t>(v[5]), static_cast<double>(v[4])});
  }
}

// Cells of all strides, row by row: body(row of the output, x cell, y cell, stride).
template <typename Body>
void each_cell(const InputSize& input, std::size_t stride, std::size_t first, Body&& body) {
  const std::size_t columns = input.width / stride, rows = input.height / stride;
  for (std::size_t y = 0; y < rows; ++y)
    for (std::size_t x = 0; x < columns; ++x) body(first++, static_cast<double>(x), static_cast<double>(y));
}
std::size_t cells(const InputSize& input, std::size_t stride) {
  return (input.width / stride) * (input.height / stride);
}

ScoredBox on_grid(const float* v, double x, double y, std::size_t stride, std::size_t object_class, double score) {
  const auto s = static_cast<double>(stride);
  return from_centre((x + static_cast<double>(v[0])) * s, (y + static_cast<double>(v[1])) * s,
                     std::exp(static_cast<double>(v[2])) * s, std::exp(static_cast<double>(v[3])) * s, object_class,
                     score);
}

void decode_yolox(const Tensor& t, const InputSize& input, Collector& out) {
  const std::size_t columns = t.shape.dims[2];
  std::size_t first = 0;
  for (const std::size_t stride : kStrides) {
    each_cell(input, stride, first, [&](std::size_t row, double x, double y) {
      const float* v = t.values.data() + row * columns;
      const auto [c, score] = best_class(v + 5, columns - 5);
      out.add(on_grid(v, x, y, stride, c, score * static_cast<double>(v[4])));
    });
    first += cells(input, stride);
  }
}

void decode_darknet(std::span<const Tensor> outputs, const InputSize& input, Collector& out) {
  const auto w = static_cast<double>(input.width), h = static_cast<double>(input.height);
  for (const auto& t : outputs) {
    const std::size_t columns = t.shape.dims.back(), rows = t.values.size() / columns;
    for (std::size_t r = 0; r < rows; ++r) {
      const float* v = t.values.data() + r * columns;
      const auto [c, score] = best_class(v + 5, columns - 5);
      out.add(from_centre(static_cast<double>(v[0]) * w, static_cast<double>(v[1]) * h, static_cast<double>(v[2]) * w,
                          static_cast<double>(v[3]) * h, c, score));
    }
  }
}

void decode_scored_boxes(const Tensor& scores, const Tensor& corners, const InputSize& input, Collector& out) {
  const auto w = static_cast<double>(input.width), h = static_cast<double>(input.height);
  const std::size_t classes = scores.shape.dims[2], background = classes > 1 ? 1 : 0;
  for (std::size_t r = 0; r < scores.shape.dims[1]; ++r) {
    const float* v = corners.values.data() + 4 * r;
    const auto [c, score] = best_class(scores.values.data() + r * classes + background, classes - background);
    out.add({{static_cast<double>(v[0]) * w, static_cast<double>(v[1]) * h, static_cast<double>(v[2]) * w,
              static_cast<double>(v[3]) * h},
             c,
             score});
  }
}

void decode_yunet(std::span<const Tensor> outputs, const InputSize& input, Collector& out) {
  const auto unit = [](float v) { return std::clamp(static_cast<double>(v), 0.0, 1.0); };
  for (const std::size_t stride : kStrides) {
    const std::string s = std::to_string(stride);
    const Tensor &cls = *named(outputs, "cls_" + s), &obj = *named(outputs, "obj_" + s),
                 &box = *named(outputs, "bbox_" + s);
    each_cell(input, stride, 0, [&](std::size_t row, double x, double y) {
      const double score = std::sqrt(unit(cls.values[row]) * unit(obj.values[row]));
      out.add(on_grid(box.values.data() + 4 * row, x, y, stride, 0, score));
    });
  }
}

std::size_t grid_rows(const InputSize& input) {
  std::size_t rows = 0;
  for (const std::size_t s : kStrides) rows += cells(input, s);
  return rows;
}

void require(bool fits, const std::vector<TensorShape>& outputs, Decoder decoder, const std::string& allowed) {
  if (!fits)
    throw unfit(outputs, "the model's outputs are not those of decoder " + std::string(name_of(decoder)), allowed);
}

void check_shapes(Decoder decoder, const std::vector<TensorShape>& o) {
  const bool single = o.size() == 1 && batched(o[0]);
  switch (decoder) {
    case Decoder::yolo_v5:
    case Decoder::yolox: require(single && o[0].dims[2] >= 6, o, decoder, "one output [1, N, 5 + classes]"); return;
    case Decoder::yolo_v8: require(single && o[0].dims[1] >= 5, o, decoder, "one output [1, 4 + classes, N]"); return;
    case Decoder::end_to_end: require(single && o[0].dims[2] == 6, o, decoder, "one output [1, N, 6]"); return;
    case Decoder::darknet:
      for (const auto& s : o)
        require((s.dims.size() == 2 || batched(s)) && s.dims.back() >= 6 && s.dims.back() == o[0].dims.back(), o,
                decoder, "outputs [N, 5 + classes]");
      require(!o.empty(), o, decoder, "outputs [N, 5 + classes]");
      return;
    case Decoder::scored_boxes:
      require(scored_pair(o).has_value(), o, decoder, "scores [1, N, classes] and corners [1, N, 4]");
      return;
    case Decoder::yunet: require(yunet_names(o), o, decoder, "cls_s, obj_s, bbox_s for s = 8, 16, 32"); return;
  }
}

}  // namespace

std::string_view name_of(Decoder decoder) {
  for (const auto& [known, name] : kNames)
    if (known == decoder) return name;
  return "unknown";
}

const std::vector<std::string>& decoder_names() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> list;
    for (const auto& entry : kNames) list.emplace_back(entry.second);
    return list;
  }();
  return names;
}

std::optional<Decoder> decoder_from(std::string_view name) {
  for (const auto& [decoder, known] : kNames)
    if (known == name) return decoder;
  return std::nullopt;
}

Preprocessing preprocessing_of(Decoder decoder) {
  switch (decoder) {
    case Decoder::yunet:
    case Decoder::yolox: return {1.0, 0.0, false};
    case Decoder::scored_boxes: return {1.0 / 128.0, 127.0, true};
    default: return {1.0 / 255.0, 0.0, true};
  }
}

Decoder recognise_decoder(const std::vector<TensorShape>& outputs) {
  if (yunet_names(outputs)) return Decoder::yunet;
  if (scored_pair(outputs)) return Decoder::scored_boxes;
  if (outputs.size() == 1 && batched(outputs[0])) {
    const std::size_t a = outputs[0].dims[1], b = outputs[0].dims[2];
    if (b == 6 && a <= kEndToEndRows) return Decoder::end_to_end;
    if (a > b && b >= 6) return Decoder::yolo_v5;
    if (a < b && a >= 5) return Decoder::yolo_v8;
  }
  const bool rows = !outputs.empty() && std::all_of(outputs.begin(), outputs.end(), [&](const auto& s) {
    // One row only is a classifier's.
    return s.dims.size() == 2 && s.dims[0] > 1 && s.dims[1] >= 6 && s.dims[1] == outputs[0].dims[1];
  });
  if (rows) return Decoder::darknet;
  throw unfit(outputs, "the model's outputs are not those of a known detector", kKnown)
      .hint("Name the decoder with --decoder, or export the detector with one of these outputs");
}

std::size_t class_count(Decoder decoder, const std::vector<TensorShape>& outputs) {
  check_shapes(decoder, outputs);
  switch (decoder) {
    case Decoder::yolo_v5:
    case Decoder::yolox: return outputs[0].dims[2] - 5;
    case Decoder::yolo_v8: return outputs[0].dims[1] - 4;
    case Decoder::darknet: return outputs[0].dims.back() - 5;
    case Decoder::scored_boxes: {
      const std::size_t classes = outputs[scored_pair(outputs)->first].dims[2];
      return classes > 1 ? classes - 1 : 1;
    }
    case Decoder::end_to_end:
    case Decoder::yunet: return 1;
  }
  return 1;
}

std::vector<ScoredBox> decode(Decoder decoder, std::span<const Tensor> outputs, const InputSize& input,
                              double min_score) {
  const auto shapes = shapes_of(outputs);
  check_shapes(decoder, shapes);
  for (const auto& t : outputs) {
    std::size_t count = 1;
    for (const std::size_t d : t.shape.dims) count *= d;
    if (t.values.size() != count) throw Error(ErrorCode::internal, "tensor without all its values");
  }
  Collector out(min_score);
  switch (decoder) {
    case Decoder::yolo_v5: decode_yolo_v5(outputs[0], out); break;
    case Decoder::yolo_v8: decode_yolo_v8(outputs[0], out); break;
    case Decoder::end_to_end: decode_end_to_end(outputs[0], out); break;
    case Decoder::yolox:
      require(shapes[0].dims[1] == grid_rows(input), shapes, decoder,
              "N = " + std::to_string(grid_rows(input)) + " cells of strides 8, 16, 32");
      decode_yolox(outputs[0], input, out);
      break;
    case Decoder::darknet: decode_darknet(outputs, input, out); break;
    case Decoder::scored_boxes: {
      const auto [scores, corners] = *scored_pair(shapes);
      decode_scored_boxes(outputs[scores], outputs[corners], input, out);
      break;
    }
    case Decoder::yunet:
      for (const std::size_t s : kStrides)
        for (const auto& [part, width] : {std::pair{"cls_", 1U}, std::pair{"obj_", 1U}, std::pair{"bbox_", 4U}})
          require(named(outputs, part + std::to_string(s))->values.size() == cells(input, s) * width, shapes, decoder,
                  "one row a cell of the input's grid");
      decode_yunet(outputs, input, out);
      break;
  }
  return std::move(out.boxes);
}

}  // namespace cairn::detection
