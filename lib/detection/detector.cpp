#include "detection/detector.hpp"

#include <algorithm>
#include <mutex>
#include <utility>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "detection/network.hpp"
#include "detection/onnx_header.hpp"
#include "detection/tiles.hpp"

namespace cairn::detection {
namespace {

using base::Error;
using base::ErrorCode;

constexpr std::size_t kOpenInput = 640;        // px, where model and user leave the input's size open
constexpr std::size_t kMostInput = 8192;       // px
constexpr std::size_t kMostCandidates = 3000;  // boxes of one tile that suppression compares

InputSize input_size(const OnnxHeader& header, const DetectOptions& options, const std::string& path) {
  if (header.inputs.size() != 1)
    throw Error(ErrorCode::invalid_input, "the model does not take one image")
        .file(path)
        .found(std::to_string(header.inputs.size()) + " inputs")
        .allowed("one input [1, 3, height, width]");
  const auto& dims = header.inputs[0].dims;
  const bool image = dims.size() == 4 && (dims[0] == 1 || dims[0] == -1) && (dims[1] == 3 || dims[1] == -1);
  if (!image) {
    std::string shape;
    for (const auto d : dims) shape += (shape.empty() ? "" : "x") + std::to_string(d);
    throw Error(ErrorCode::invalid_input, "the model's input is not one image of three channels")
        .file(path)
        .found(header.inputs[0].name + " " + shape)
        .allowed("[1, 3, height, width]");
  }
  const auto side = [&](std::int64_t declared) {
    if (declared > 0) return static_cast<std::size_t>(declared);
    return options.input_px > 0 ? static_cast<std::size_t>(options.input_px) : kOpenInput;
  };
  const InputSize size{side(dims[3]), side(dims[2])};
  if (size.width > kMostInput || size.height > kMostInput)
    throw Error(ErrorCode::invalid_input, "the model's input is too large")
        .file(path)
        .found(std::to_string(size.width) + " x " + std::to_string(size.height))
        .allowed("at most " + std::to_string(kMostInput) + " px");
  return size;
}

std::vector<std::string> output_names(const OnnxHeader& header) {
  std::vector<std::string> names;
  for (const auto& output : header.outputs) names.push_back(output.name);
  return names;
}

geometry::PixelBox clipped(const geometry::PixelBox& b, double width, double height) {
  return {std::clamp(b.xmin, 0.0, width), std::clamp(b.ymin, 0.0, height), std::clamp(b.xmax, 0.0, width),
          std::clamp(b.ymax, 0.0, height)};
}

}  // namespace

struct Detector::Impl {
  std::filesystem::path path;
  std::string model;
  DetectOptions options;
  InputSize input;
  std::vector<std::string> outputs;
  Decoder decoder = Decoder::yolo_v5;
  Preprocessing preprocessing;
  DetectorFacts facts;
  std::mutex mutex;
  std::vector<Network> idle;  // networks no thread is using

  Network take() {
    {
      const std::lock_guard lock(mutex);
      if (!idle.empty()) {
        Network network = std::move(idle.back());
        idle.pop_back();
        return network;
      }
    }
    return {model, path, outputs, input};
  }
  void give_back(Network network) {
    const std::lock_guard lock(mutex);
    idle.push_back(std::move(network));
  }

  // A grey image through the network: its outputs' shapes.
  std::vector<TensorShape> probe() {
    geometry::ColourImage grey{input.width, input.height, {}};
    grey.values.assign(3 * input.width * input.height, 114);
    Network network = take();
    const auto tensors = network.run(grey, letterbox({0, 0, input.width, input.height}, input), {});
    give_back(std::move(network));
    std::vector<TensorShape> shapes;
    for (const auto& t : tensors) shapes.push_back(t.shape);
    return shapes;
  }

  void choose_decoder(const std::vector<TensorShape>& shapes) {
    try {
      decoder = options.decoder == "auto" ? recognise_decoder(shapes) : decoder_from(options.decoder).value();
      facts.classes.resize(class_count(decoder, shapes));
    } catch (Error& e) {
      e.default_file(path.string());
      throw;
    }
    preprocessing = preprocessing_of(decoder);
    if (options.channels != "auto") preprocessing.rgb = options.channels == "rgb";
    if (options.input_scale > 0.0) preprocessing.scale = options.input_scale;
    if (options.input_mean >= 0.0) preprocessing.mean = options.input_mean;
  }

  void name_classes(const std::vector<std::string>& given, const std::vector<std::string>& of_model) {
    auto& names = facts.classes;
    // The number of classes of end-to-end outputs does not show.
    if (decoder == Decoder::end_to_end) names.resize(std::max({names.size(), given.size(), of_model.size()}));
    if (given.size() > names.size())
      throw Error(ErrorCode::invalid_argument, "more class names than the model has classes")
          .file(path.string())
          .found(std::to_string(given.size()) + " names")
          .allowed("at most " + std::to_string(names.size()));
    const bool face = decoder == Decoder::yunet || decoder == Decoder::scored_boxes;
    for (std::size_t i = 0; i < names.size(); ++i) {
      if (i < given.size() && !given[i].empty()) names[i] = given[i];
      else if (i < of_model.size() && !of_model[i].empty()) names[i] = of_model[i];
      else if (names.size() == 1) names[i] = face ? "face" : "object";
      else names[i] = "class_" + std::to_string(i);
    }
  }

  [[nodiscard]] std::vector<PixelRect> parts(std::size_t width, std::size_t height) const {
    InputSize tile{width, height};
    if (options.tile_px > 0) {
      const auto side = static_cast<std::size_t>(options.tile_px);
      tile = {side, side};
    } else if (options.tile_px == 0 && (width > 2 * input.width || height > 2 * input.height)) {
      tile = input;
    }
    return plan_tiles(width, height, tile, options.overlap);
  }

  std::vector<TileBox> look(Network& network, const geometry::ColourImage& image, const PixelRect& part,
                            std::size_t index) const {
    const Letterbox fit = letterbox(part, input);
    auto found = decode(decoder, network.run(image, fit, preprocessing), input, options.min_score);
    std::stable_sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return a.score > b.score; });
    if (found.size() > kMostCandidates) found.resize(kMostCandidates);
    std::vector<TileBox> boxes;
    for (ScoredBox b : suppress(found, options.nms_iou)) {
      b.box = clipped(fit.to_image(b.box), static_cast<double>(image.width_px), static_cast<double>(image.height_px));
      if (b.object_class >= facts.classes.size() || !(b.box.width() > 0.0 && b.box.height() > 0.0)) continue;
      boxes.push_back({b, index});
    }
    return boxes;
  }
};

Detector::Detector(const std::filesystem::path& model, const DetectOptions& options,
                   std::vector<std::string> class_names)
    : impl_(std::make_unique<Impl>()) {
  impl_->options = options;
  base::validate(base::bind_options(impl_->options), "detect");
  impl_->path = model;
  impl_->model = base::read_file(model);
  const OnnxHeader header = read_onnx_header(impl_->model, model.string());
  impl_->input = input_size(header, options, model.string());
  impl_->outputs = output_names(header);
  const auto shapes = impl_->probe();
  impl_->choose_decoder(shapes);
  impl_->name_classes(class_names, class_names_from_metadata(header));
  impl_->facts.decoder = name_of(impl_->decoder);
  impl_->facts.input_width_px = impl_->input.width;
  impl_->facts.input_height_px = impl_->input.height;
  impl_->facts.outputs = describe(shapes);
}

Detector::~Detector() = default;
Detector::Detector(Detector&&) noexcept = default;
Detector& Detector::operator=(Detector&&) noexcept = default;

const DetectorFacts& Detector::facts() const {
  return impl_->facts;
}

const std::string& Detector::class_name(std::size_t object_class) const {
  return impl_->facts.classes.at(object_class);
}

std::size_t Detector::tiles_of(std::size_t width_px, std::size_t height_px) const {
  const std::size_t tiles = impl_->parts(width_px, height_px).size();
  return tiles + (impl_->options.whole && tiles > 1 ? 1 : 0);
}

std::vector<ScoredBox> Detector::detect(const geometry::ColourImage& image) const {
  if (image.width_px == 0 || image.height_px == 0) return {};
  auto parts = impl_->parts(image.width_px, image.height_px);
  if (impl_->options.whole && parts.size() > 1) parts.push_back({0, 0, image.width_px, image.height_px});
  Network network = impl_->take();
  std::vector<TileBox> boxes;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const auto found = impl_->look(network, image, parts[i], i);
    boxes.insert(boxes.end(), found.begin(), found.end());
  }
  impl_->give_back(std::move(network));
  SeamOptions seams;
  seams.nms_iou = impl_->options.nms_iou;
  return merge_tiles(boxes, parts, image.width_px, image.height_px, seams);
}

}  // namespace cairn::detection
