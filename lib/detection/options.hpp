// Options of detector inference.
#pragma once

#include <cstdint>
#include <string>

#include "base/options.hpp"

namespace cairn::detection {

struct DetectOptions {
  std::string decoder = "auto";   // how outputs become boxes; auto: recognised from their names and shapes
  double min_score = 0.25;        // boxes with a lower score are dropped, 0..1
  double nms_iou = 0.45;          // of two boxes of one class that overlap by more, the better stays, 0..1
  std::int64_t input_px = 0;      // side of the network's input where the model leaves it open; 0 = 640
  std::int64_t tile_px = 0;       // side of a tile, image px; 0 = auto: the input's size where the photo is more than
                                  // twice as large, else no tiles; -1 = never tile
  double overlap = 0.25;          // least share of a tile's side that neighbours have in common, 0..0.9
  bool whole = false;             // look at the whole photo too, for objects larger than a tile's overlap
  std::string channels = "auto";  // order the network wants: rgb, bgr; auto = the decoder's
  double input_scale = 0.0;       // value = (pixel - mean) * scale; 0 = the decoder's (1/255 for YOLO)
  double input_mean = -1.0;       // -1 = the decoder's (0 for YOLO)

  void visit(base::OptionVisitor& visitor);
};

}  // namespace cairn::detection
