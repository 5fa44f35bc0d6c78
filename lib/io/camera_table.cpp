#include "io/camera_table.hpp"

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <string>
#include <string_view>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "base/number_text.hpp"

namespace cairn::io {
namespace {

using base::Error;
using base::ErrorCode;

constexpr std::size_t kColumns = 18;
constexpr double kOrthonormal = 1e-6;  // tables are written with nine digits
constexpr double kLargestImage = 1e6;  // px

std::array<double, kColumns> numbers(std::string_view row, const std::string& file, const std::string& record) {
  std::array<double, kColumns> values{};
  std::size_t count = 0;
  for (std::size_t at = row.find_first_not_of(" \t"); at != std::string_view::npos;) {
    const std::size_t end = std::min(row.find_first_of(" \t", at), row.size());
    const auto value = base::parse_real(row.substr(at, end - at));
    if (!value || !std::isfinite(*value))
      throw Error(ErrorCode::invalid_input, "not a finite number")
          .file(file)
          .record(record)
          .found(row.substr(at, std::min<std::size_t>(end - at, 40)));
    if (count < kColumns) values[count] = *value;
    ++count;
    at = row.find_first_not_of(" \t", end);
  }
  if (count != kColumns)
    throw Error(ErrorCode::invalid_input, "a camera has the wrong number of values")
        .file(file)
        .record(record)
        .found(std::to_string(count))
        .allowed("18: x y z, nine of the rotation world -> camera, fx fy cx cy width height");
  return values;
}

TableView view_of(const std::array<double, kColumns>& n, const std::string& file, const std::string& record) {
  TableView view;
  view.T_world_camera.translation = geometry::Vec3(n[0], n[1], n[2]);
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column)
      view.T_world_camera.rotation(column, row) = n[static_cast<std::size_t>(3 + 3 * row + column)];
  const geometry::Mat3& R = view.T_world_camera.rotation;
  const double off = (R.transpose() * R - geometry::Mat3::Identity()).cwiseAbs().maxCoeff();
  const double determinant = R.col(0).cross(R.col(1)).dot(R.col(2));
  if (!(off <= kOrthonormal) || determinant < 0.0)
    throw Error(ErrorCode::invalid_input, "a camera's rotation is not a rotation")
        .file(file)
        .record(record)
        .found(determinant < 0.0 ? "determinant " + base::to_text(determinant) : "off by " + base::to_text(off))
        .allowed("orthonormal within 1e-6, determinant 1");
  const auto size = [](double v) { return v >= 1.0 && v <= kLargestImage && v == std::floor(v); };
  if (!(n[12] > 0.0 && n[13] > 0.0 && size(n[16]) && size(n[17])))
    throw Error(ErrorCode::invalid_input, "a camera's focal length or image size is wrong")
        .file(file)
        .record(record)
        .allowed("fx, fy > 0; width and height whole numbers of pixels");
  view.camera.fx_px = n[12];
  view.camera.fy_px = n[13];
  view.camera.cx_px = n[14];
  view.camera.cy_px = n[15];
  view.camera.width_px = static_cast<std::int64_t>(n[16]);
  view.camera.height_px = static_cast<std::int64_t>(n[17]);
  return view;
}

}  // namespace

std::vector<TableView> read_camera_table(const std::filesystem::path& path) {
  constexpr std::uintmax_t kLargestTable = std::uintmax_t{1} << 30;
  const std::string text = base::read_file(path, kLargestTable);
  std::vector<TableView> views;
  std::size_t line = 0;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    ++line;
    const auto row = base::trim(std::string_view(text).substr(begin, end - begin));
    begin = end + 1;
    if (row.empty() || row.front() == '#') continue;
    const std::string record = "line " + std::to_string(line);
    views.push_back(view_of(numbers(row, path.string(), record), path.string(), record));
  }
  return views;
}

}  // namespace cairn::io
