#include <array>
#include <cmath>

#include "base/number_text.hpp"
#include "pipeline/import_dji.hpp"

namespace cairn::pipeline {
namespace {

constexpr double kFilmWidthMm = 36.0;  // the 35 mm format: equivalence by width

// "2020-01-01;fx,fy,cx,cy,k1,k2,p1,p2,k3" in pixels of the original; cx, cy from the photo's centre.
std::optional<std::array<double, 9>> dewarp_values(std::string_view text) {
  if (const auto semicolon = text.rfind(';'); semicolon != std::string_view::npos) text.remove_prefix(semicolon + 1);
  std::array<double, 9> values{};
  for (std::size_t i = 0; i < values.size(); ++i) {
    const auto comma = text.find(',');
    const auto value = base::parse_real(text.substr(0, comma));
    if (!value || !std::isfinite(*value) || (comma == std::string_view::npos) != (i + 1 == values.size()))
      return std::nullopt;
    values[i] = *value;
    text.remove_prefix(comma == std::string_view::npos ? text.size() : comma + 1);
  }
  return values;
}

}  // namespace

std::optional<survey::Camera> dji_camera(const io::ImageMetadata& metadata, bool& from_dewarp) {
  survey::Camera c;
  c.width_px = metadata.size.width_px;
  c.height_px = metadata.size.height_px;
  const auto width = static_cast<double>(c.width_px), height = static_cast<double>(c.height_px);
  c.cx_px = 0.5 * width;
  c.cy_px = 0.5 * height;
  from_dewarp = false;
  if (const auto dewarp = dewarp_values(metadata.dji.dewarp_data); dewarp && (*dewarp)[0] > 0.0 && (*dewarp)[1] > 0.0) {
    const auto& [fx, fy, cx, cy, k1, k2, p1, p2, k3] = *dewarp;
    // The values are for the photograph as taken; the file may have been reduced since.
    const double scale = metadata.exif_size ? width / static_cast<double>(metadata.exif_size->width_px) : 1.0;
    c.fx_px = fx * scale;
    c.fy_px = fy * scale;
    c.cx_px += cx * scale;
    c.cy_px += cy * scale;
    if (!metadata.dji.dewarped) {
      c.model = survey::CameraModel::brown;
      c.k1 = k1;
      c.k2 = k2;
      c.k3 = k3;
      c.p1 = p1;
      c.p2 = p2;
    }
    from_dewarp = true;
    return c;
  }
  if (!metadata.focal_length_35mm_mm) return std::nullopt;
  c.fx_px = c.fy_px = *metadata.focal_length_35mm_mm / kFilmWidthMm * width;
  return c;
}

}  // namespace cairn::pipeline
