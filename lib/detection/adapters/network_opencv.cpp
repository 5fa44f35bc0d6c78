#include <mutex>
#include <opencv2/core.hpp>
#include <opencv2/core/utils/logger.hpp>
#include <opencv2/dnn.hpp>
#include <opencv2/imgproc.hpp>

#include "base/error.hpp"
#include "detection/network.hpp"

namespace cairn::detection {
namespace {

using base::Error;
using base::ErrorCode;

constexpr double kGrey = 114.0;  // what YOLO networks are trained to see beside the image

// The library prints its errors unless told not to, and splits work over threads.
void set_library_up() {
  static std::once_flag once;
  std::call_once(once, [] {
    cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
    cv::redirectError([](int, const char*, const char*, const char*, int, void*) { return 0; });
    cv::setNumThreads(1);
  });
}

// The sentence of the library's message: "OpenCV(4.6.0) file:line: error: (code) text in function 'f'".
std::string sentence(const cv::Exception& e) {
  std::string text = e.err.empty() ? e.what() : e.err;
  if (const auto end = text.find('\n'); end != std::string::npos) text.resize(end);
  constexpr std::size_t kMost = 200;
  if (text.size() > kMost) text = text.substr(0, kMost) + "...";
  return text;
}

Error cannot(const std::string& what, const std::string& path, const cv::Exception& e) {
  return Error(ErrorCode::invalid_input, "the model cannot be " + what + " by OpenCV " + CV_VERSION)
      .file(path)
      .found(sentence(e))
      .allowed(
          "ONNX of operators that OpenCV's dnn module knows: convolutions, pooling, resizing, matrix products, "
          "softmax; no LayerNormalization, no loops")
      .hint(
          "Export it again with opset 11 or 12, a fixed input size and simplified (onnxsim), or use another detector");
}

}  // namespace

struct Network::Impl {
  cv::dnn::Net net;
  std::vector<std::string> outputs;
  InputSize input;
  std::string path;
};

Network::Network(std::string_view model, const std::filesystem::path& path, std::vector<std::string> outputs,
                 const InputSize& input)
    : impl_(std::make_unique<Impl>()) {
  set_library_up();
  impl_->outputs = std::move(outputs);
  impl_->input = input;
  impl_->path = path.string();
  try {
    impl_->net = cv::dnn::readNetFromONNX(model.data(), model.size());
    impl_->net.setPreferableBackend(cv::dnn::DNN_BACKEND_OPENCV);
    impl_->net.setPreferableTarget(cv::dnn::DNN_TARGET_CPU);
  } catch (const cv::Exception& e) {
    throw cannot("loaded", impl_->path, e);
  }
  if (impl_->net.empty())
    throw Error(ErrorCode::invalid_input, "the model holds no network").file(impl_->path).hint("Export it again");
}

Network::~Network() = default;
Network::Network(Network&&) noexcept = default;
Network& Network::operator=(Network&&) noexcept = default;

std::vector<Tensor> Network::run(const geometry::ColourImage& image, const Letterbox& fit,
                                 const Preprocessing& preprocessing) {
  const auto whole = [](std::size_t v) { return static_cast<int>(v); };
  // The library reads only; its header of foreign memory has no const form.
  const cv::Mat all(whole(image.height_px), whole(image.width_px), CV_8UC3,
                    const_cast<std::uint8_t*>(image.values.data()));
  const cv::Mat part =
      all(cv::Rect(whole(fit.part.x), whole(fit.part.y), whole(fit.part.width), whole(fit.part.height)));
  try {
    cv::Mat scaled = part;
    if (fit.scaled_width != fit.part.width || fit.scaled_height != fit.part.height)
      cv::resize(part, scaled, cv::Size(whole(fit.scaled_width), whole(fit.scaled_height)), 0, 0,
                 fit.scaled_width < fit.part.width ? cv::INTER_AREA : cv::INTER_LINEAR);
    cv::Mat canvas(whole(impl_->input.height), whole(impl_->input.width), CV_8UC3, cv::Scalar::all(kGrey));
    scaled.copyTo(
        canvas(cv::Rect(whole(fit.pad_x), whole(fit.pad_y), whole(fit.scaled_width), whole(fit.scaled_height))));
    const cv::Mat blob = cv::dnn::blobFromImage(canvas, preprocessing.scale, cv::Size(),
                                                cv::Scalar::all(preprocessing.mean), !preprocessing.rgb);
    impl_->net.setInput(blob);
    std::vector<cv::Mat> found;
    impl_->net.forward(found, impl_->outputs);
    std::vector<Tensor> tensors;
    for (std::size_t i = 0; i < found.size(); ++i) {
      Tensor t;
      t.shape.name = impl_->outputs[i];
      for (int d = 0; d < found[i].dims; ++d) t.shape.dims.push_back(static_cast<std::size_t>(found[i].size[d]));
      cv::Mat values;
      found[i].convertTo(values, CV_32F);
      t.values.assign(values.ptr<float>(), values.ptr<float>() + values.total());
      tensors.push_back(std::move(t));
    }
    return tensors;
  } catch (const cv::Exception& e) {
    throw cannot("computed", impl_->path, e);
  }
}

}  // namespace cairn::detection
