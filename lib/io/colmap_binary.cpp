#include <bit>
#include <cmath>
#include <cstring>
#include <string>

#include "base/error.hpp"
#include "base/number_text.hpp"
#include "io/colmap_model.hpp"

namespace cairn::io {
namespace {

using base::Error;
using base::ErrorCode;

constexpr std::uint64_t kNoPoint = ~std::uint64_t{0};  // COLMAP's kInvalidPoint3DId
constexpr std::size_t kMaxNameBytes = 4096;

// Little-endian values of a byte string; every step is bounded.
class Bytes {
 public:
  Bytes(std::string_view bytes, std::string file) : bytes_(bytes), file_(std::move(file)) {}

  template <typename T>
  T take(std::string_view what) {
    need(sizeof(T), what);
    // Byte by byte, so that a big-endian machine reads the same.
    std::uint64_t raw = 0;
    for (std::size_t i = 0; i < sizeof(T); ++i)
      raw |= std::uint64_t{static_cast<unsigned char>(bytes_[offset_ + i])} << (8 * i);
    offset_ += sizeof(T);
    if constexpr (std::is_same_v<T, double>) return std::bit_cast<double>(raw);
    else return static_cast<T>(raw);
  }
  double real(std::string_view what) {
    const double value = take<double>(what);
    if (!std::isfinite(value)) fail(std::string(what) + " is not finite", base::to_text(value), "a finite number");
    return value;
  }
  // A count of records of at least `bytes_each` bytes: more than the file can hold is refused.
  std::size_t count(std::size_t bytes_each, std::string_view what) {
    const auto n = take<std::uint64_t>(what);
    const std::size_t possible = (bytes_.size() - offset_) / bytes_each;
    if (n > possible)
      fail("number of " + std::string(what) + " is more than the file can hold", std::to_string(n),
           "at most " + std::to_string(possible));
    return static_cast<std::size_t>(n);
  }
  std::string name() {
    const std::string_view rest = bytes_.substr(offset_, kMaxNameBytes);
    const auto end = rest.find('\0');
    if (end == std::string_view::npos) fail("image name does not end", "", "a name of at most 4095 bytes");
    offset_ += end + 1;
    return std::string(rest.substr(0, end));
  }
  void expect_end() {
    if (offset_ != bytes_.size()) fail("bytes after the last record", std::to_string(bytes_.size() - offset_), "none");
  }
  std::int64_t id(std::uint64_t raw, std::string_view what) {
    if (raw > static_cast<std::uint64_t>(INT64_MAX))
      fail(std::string(what) + " id out of range", std::to_string(raw), "63 bits");
    return static_cast<std::int64_t>(raw);
  }
  [[noreturn]] void fail(std::string message, const std::string& found, const std::string& allowed) const {
    throw Error(ErrorCode::invalid_input, std::move(message))
        .file(file_)
        .record(record())
        .found(found)
        .allowed(allowed);
  }
  [[nodiscard]] std::string record() const { return "byte " + std::to_string(offset_); }
  [[noreturn]] void place(Error& error) const {
    if (error.file().empty()) throw std::move(error).file(file_).record(record());
    throw std::move(error);
  }

 private:
  void need(std::size_t n, std::string_view what) const {
    if (bytes_.size() - offset_ < n)
      throw Error(ErrorCode::invalid_input, "file ends inside " + std::string(what))
          .file(file_)
          .record(record())
          .found(std::to_string(bytes_.size() - offset_) + " bytes left")
          .allowed(std::to_string(n))
          .hint("The file is cut off; copy or export it again");
  }

  std::string_view bytes_;
  std::string file_;
  std::size_t offset_ = 0;
};

void read_cameras(Bytes& in, ColmapModel& model) {
  constexpr std::size_t kLeast = 4 + 4 + 8 + 8 + 3 * 8;
  for (std::size_t n = in.count(kLeast, "cameras"); n > 0; --n) {
    const std::int64_t id = in.take<std::uint32_t>("camera id");
    const int model_id = in.take<std::int32_t>("camera model");
    const auto width = static_cast<double>(in.take<std::uint64_t>("width"));
    const auto height = static_cast<double>(in.take<std::uint64_t>("height"));
    const ColmapCameraModel* known = find_colmap_model(model_id);
    if (known == nullptr) in.fail("unknown camera model", std::to_string(model_id), "0 to 10");
    require_supported(*known);
    std::vector<double> parameters(known->parameters);
    for (auto& value : parameters) value = in.take<double>("camera parameter");
    model.cameras.push_back(make_colmap_camera(id, *known, width, height, parameters));
  }
  in.expect_end();
}

void read_images(Bytes& in, ColmapModel& model) {
  constexpr std::size_t kLeast = 4 + 7 * 8 + 4 + 1 + 8, kKeyPoint = 3 * 8;
  for (std::size_t n = in.count(kLeast, "images"); n > 0; --n) {
    ColmapImage image;
    image.id = in.take<std::uint32_t>("image id");
    std::array<double, 7> pose{};
    for (auto& value : pose) value = in.take<double>("pose");
    image.T_world_camera = invert_colmap_pose(pose);
    image.camera = in.take<std::uint32_t>("camera id");
    image.name = in.name();
    if (image.name.empty()) in.fail("image without a name", "", "");
    const std::size_t key_points = in.count(kKeyPoint, "key points");
    for (std::size_t i = 0; i < key_points; ++i) {
      const double x = in.real("key point"), y = in.real("key point");
      const auto point = in.take<std::uint64_t>("3-D point id");
      if (point != kNoPoint)
        image.observations.push_back({static_cast<std::int64_t>(i), in.id(point, "point"), {x, y}});
    }
    model.images.push_back(std::move(image));
  }
  in.expect_end();
}

void read_points(Bytes& in, ColmapModel& model, std::vector<ColmapTrackElement>& tracks) {
  constexpr std::size_t kLeast = 8 + 3 * 8 + 3 + 8 + 8, kTrackElement = 8;
  for (std::size_t n = in.count(kLeast, "points"); n > 0; --n) {
    ColmapPoint point;
    point.id = in.id(in.take<std::uint64_t>("point id"), "point");
    for (int i = 0; i < 3; ++i) point.position[i] = in.real("point coordinate");
    for (auto& channel : point.rgb) channel = in.take<std::uint8_t>("colour");
    point.error_px = in.real("reprojection error");
    for (std::size_t length = in.count(kTrackElement, "track elements"); length > 0; --length) {
      const std::int64_t image = in.take<std::uint32_t>("track");
      tracks.push_back({point.id, image, in.take<std::uint32_t>("track")});
    }
    model.points.push_back(point);
  }
  in.expect_end();
}

}  // namespace

ColmapModel parse_colmap_binary(const ColmapFiles& files) {
  ColmapModel model;
  model.binary = true;
  const std::string cameras_file = (files.folder / "cameras.bin").string(),
                    images_file = (files.folder / "images.bin").string(),
                    points_file = (files.folder / "points3D.bin").string();
  std::vector<ColmapTrackElement> tracks;
  const auto read = [](std::string_view bytes, const std::string& file, auto&& body) {
    Bytes in(bytes, file);
    try {
      body(in);
    } catch (Error& error) {
      in.place(error);
    }
  };
  read(files.cameras, cameras_file, [&](Bytes& in) { read_cameras(in, model); });
  read(files.images, images_file, [&](Bytes& in) { read_images(in, model); });
  // No file of points is a model without points; a cut file is not.
  if (files.points.data() != nullptr)
    read(files.points, points_file, [&](Bytes& in) { read_points(in, model, tracks); });
  finish_colmap_model(model, tracks, images_file, points_file);
  return model;
}

}  // namespace cairn::io
