#include "detection/options.hpp"

#include "detection/decoder.hpp"

namespace cairn::detection {

void DetectOptions::visit(base::OptionVisitor& visitor) {
  std::vector<std::string> decoders{"auto"};
  decoders.insert(decoders.end(), decoder_names().begin(), decoder_names().end());
  visitor.choice("decoder", decoder, decoders, "how the network's outputs become boxes");
  visitor.real("min-score", min_score, 0.0, 1.0, "boxes with a lower score are dropped");
  visitor.real("nms-iou", nms_iou, 0.0, 1.0, "of two boxes of one class that overlap by more, the better one stays");
  visitor.integer("input-px", input_px, 0, 8192, "side of the input of a model that leaves it open; 0 = 640");
  visitor.integer("tile-px", tile_px, -1, 65536,
                  "side of a tile; 0 = the input's size for photos more than twice as large; -1 = no tiles");
  visitor.real("overlap", overlap, 0.0, 0.9, "least share of a tile's side that neighbours have in common");
  visitor.flag("whole", whole, "look at the whole photo too, for objects larger than a tile");
  visitor.choice("channels", channels, {"auto", "rgb", "bgr"}, "order of the colours the network wants");
  visitor.real("input-scale", input_scale, 0.0, 1e3, "network input = (pixel - mean) * scale; 0 = the decoder's");
  visitor.real("input-mean", input_mean, -1.0, 255.0, "see input-scale; -1 = the decoder's");
}

}  // namespace cairn::detection
