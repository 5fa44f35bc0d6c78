// From a network's output tensors to boxes.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "detection/letterbox.hpp"
#include "detection/suppression.hpp"
#include "detection/tensor.hpp"

namespace cairn::detection {

//   yolo_v5      [1, N, 5 + C]: centre, size (input px), objectness, class scores; score = objectness * best class
//   yolo_v8      [1, 4 + C, N]: centre, size (input px), class scores
//   end_to_end   [1, N, 6]: corners (input px), score, class; suppression was done in the network
//   yolox        [1, N, 5 + C] on the grids of strides 8, 16, 32: centre = (cell + value) stride, size = exp(value)
//   stride darknet      one or more [N, 5 + C]: centre, size (shares of the input), objectness, class scores with it
//   scored_boxes scores [1, N, C] (class 0 = background where C > 1) and corners [1, N, 4] (shares of the input)
//   yunet        cls_s, obj_s, bbox_s for strides s = 8, 16, 32: score = sqrt(cls obj), boxes as yolox
enum class Decoder { yolo_v5, yolo_v8, end_to_end, yolox, darknet, scored_boxes, yunet };

[[nodiscard]] std::string_view name_of(Decoder decoder);
[[nodiscard]] const std::vector<std::string>& decoder_names();
[[nodiscard]] std::optional<Decoder> decoder_from(std::string_view name);

// What the decoder's networks were trained on: value = (pixel - mean) * scale, channels in this order.
struct Preprocessing {
  double scale = 1.0 / 255.0, mean = 0.0;
  bool rgb = true;
};
[[nodiscard]] Preprocessing preprocessing_of(Decoder decoder);

// The decoder that these outputs fit, by names (yunet, scored_boxes), then shapes; yolox and yolo_v5 look alike, the
// latter is taken. Throws invalid_input that lists the shapes where none fits.
[[nodiscard]] Decoder recognise_decoder(const std::vector<TensorShape>& outputs);

// Number of classes that the outputs tell apart. Throws as decode.
[[nodiscard]] std::size_t class_count(Decoder decoder, const std::vector<TensorShape>& outputs);

// Boxes with a score of at least min_score, in input px, in the order of the output. Boxes that are not finite or have
// no area are left out. Throws invalid_input that lists the shapes where they are not the decoder's.
[[nodiscard]] std::vector<ScoredBox> decode(Decoder decoder, std::span<const Tensor> outputs, const InputSize& input,
                                            double min_score);

}  // namespace cairn::detection
