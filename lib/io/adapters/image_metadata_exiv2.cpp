// EXIF and XMP by Exiv2 0.27. Whatever it throws, on whatever bytes, leaves here as base::Error.
#include <exiv2/exiv2.hpp>

#include <array>
#include <cmath>
#include <mutex>
#include <string>
#include <utility>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "base/number_text.hpp"
#include "base/time.hpp"
#include "io/image.hpp"
#include "io/image_metadata.hpp"

namespace cairn::io {
namespace {

using base::Error;
using base::ErrorCode;

// Exiv2's XMP toolkit has global state: initialised once, used under one lock.
std::mutex& exiv2_lock() {
  static std::mutex lock;
  return lock;
}

void prepare_exiv2() {
  static const bool ready = [] {
    Exiv2::LogMsg::setLevel(Exiv2::LogMsg::mute);
    Exiv2::XmpParser::initialize();
    Exiv2::XmpProperties::registerNs("http://www.dji.com/drone-dji/1.0/", "drone-dji");
    return true;
  }();
  static_cast<void>(ready);
}

std::optional<double> ratio(double numerator, double denominator) {
  if (denominator == 0.0) return std::nullopt;
  return numerator / denominator;
}

// Element i of a tag, read from its own type: Exiv2's conversions wrap unsigned values.
std::optional<double> element(const Exiv2::Value& value, std::size_t i) {
  if (i >= static_cast<std::size_t>(value.count())) return std::nullopt;
  if (const auto* v = dynamic_cast<const Exiv2::URationalValue*>(&value))
    return ratio(v->value_[i].first, v->value_[i].second);
  if (const auto* v = dynamic_cast<const Exiv2::RationalValue*>(&value))
    return ratio(v->value_[i].first, v->value_[i].second);
  if (const auto* v = dynamic_cast<const Exiv2::UShortValue*>(&value)) return v->value_[i];
  if (const auto* v = dynamic_cast<const Exiv2::ULongValue*>(&value)) return v->value_[i];
  return base::parse_real(value.toString(static_cast<long>(i)));
}

class Tags {
 public:
  Tags(const Exiv2::ExifData& exif, const Exiv2::XmpData& xmp) : exif_(exif), xmp_(xmp) {}

  [[nodiscard]] const Exiv2::Value* value(const char* key) const {
    const auto it = exif_.findKey(Exiv2::ExifKey(key));
    return it == exif_.end() || it->count() == 0 ? nullptr : &it->value();
  }
  [[nodiscard]] std::string text(const char* key) const {
    const auto* v = value(key);
    if (v == nullptr) return {};
    std::string text = v->toString();
    text.resize(std::min(text.find('\0'), text.size()));
    return std::string(base::trim(text));
  }
  [[nodiscard]] std::optional<double> real(const char* key, std::size_t i = 0) const {
    const auto* v = value(key);
    auto number = v == nullptr ? std::nullopt : element(*v, i);
    if (number && !std::isfinite(*number)) number.reset();
    return number;
  }
  [[nodiscard]] std::optional<double> positive(const char* key) const {
    auto number = real(key);
    if (number && !(*number > 0.0)) number.reset();  // 0 = not known (Exif 2.3, FocalLengthIn35mmFilm)
    return number;
  }
  [[nodiscard]] std::string dji_text(const char* name) const {
    const auto it = xmp_.findKey(Exiv2::XmpKey(std::string("Xmp.drone-dji.") + name));
    return it == xmp_.end() ? std::string() : std::string(base::trim(it->toString()));
  }
  [[nodiscard]] std::optional<double> dji_real(const char* name) const {
    auto number = base::parse_real(dji_text(name));
    if (number && !std::isfinite(*number)) number.reset();
    return number;
  }

 private:
  const Exiv2::ExifData& exif_;
  const Exiv2::XmpData& xmp_;
};

// "2016:06:23 16:31:59"; cameras without a clock write zeros or blanks.
std::optional<std::int64_t> civil_time(const Tags& tags) {
  const std::string text = tags.text("Exif.Photo.DateTimeOriginal");
  if (text.size() != 19 || text[4] != ':' || text[7] != ':' || text[13] != ':' || text[16] != ':') return std::nullopt;
  constexpr std::array<std::pair<std::size_t, std::size_t>, 6> kFields{
      {{0, 4}, {5, 2}, {8, 2}, {11, 2}, {14, 2}, {17, 2}}};
  std::array<int, 6> fields{};
  for (std::size_t i = 0; i < kFields.size(); ++i) {
    const std::string part = text.substr(kFields[i].first, kFields[i].second);
    if (part.find_first_not_of("0123456789") != std::string::npos) return std::nullopt;
    fields[i] = static_cast<int>(*base::parse_integer(part));
  }
  double fraction = 0.0;
  const std::string sub = tags.text("Exif.Photo.SubSecTimeOriginal");
  if (!sub.empty() && sub.size() <= 9 && sub.find_first_not_of("0123456789") == std::string::npos)
    fraction = base::parse_real("0." + sub).value_or(0.0);
  return base::civil_to_ns(fields[0], fields[1], fields[2], fields[3], fields[4], fields[5] + fraction);
}

// Degrees, minutes, seconds; the finer parts may be absent, the degrees not.
std::optional<double> angle_of(const Tags& tags, const char* key, const char* ref_key, std::string_view negative) {
  const auto degrees = tags.real(key, 0);
  const std::string ref = tags.text(ref_key);
  if (!degrees || ref.empty()) return std::nullopt;
  const double value = *degrees + tags.real(key, 1).value_or(0.0) / 60.0 + tags.real(key, 2).value_or(0.0) / 3600.0;
  return ref == negative ? -value : value;
}

void require_on_globe(const std::optional<double>& value, double limit, std::string_view what, std::string_view name) {
  if (value && !(std::abs(*value) <= limit))
    throw Error(ErrorCode::invalid_input, std::string(what) + " out of range")
        .file(name)
        .record("GPS position")
        .found(base::to_text(*value))
        .allowed(base::to_text(-limit) + " to " + base::to_text(limit))
        .hint("Correct the GPS tags of the image, or leave it out");
}

DjiMetadata dji_of(const Tags& tags) {
  DjiMetadata d;
  d.gimbal_yaw_deg = tags.dji_real("GimbalYawDegree");
  d.gimbal_pitch_deg = tags.dji_real("GimbalPitchDegree");
  d.gimbal_roll_deg = tags.dji_real("GimbalRollDegree");
  d.flight_yaw_deg = tags.dji_real("FlightYawDegree");
  d.flight_pitch_deg = tags.dji_real("FlightPitchDegree");
  d.flight_roll_deg = tags.dji_real("FlightRollDegree");
  d.relative_altitude_m = tags.dji_real("RelativeAltitude");
  d.absolute_altitude_m = tags.dji_real("AbsoluteAltitude");
  d.rtk_flag = base::parse_integer(tags.dji_text("RtkFlag"));
  d.rtk_std_lon_m = tags.dji_real("RtkStdLon");
  d.rtk_std_lat_m = tags.dji_real("RtkStdLat");
  d.rtk_std_hgt_m = tags.dji_real("RtkStdHgt");
  d.latitude_deg = tags.dji_real("GpsLatitude");
  d.longitude_deg = tags.dji_real("GpsLongitude");
  if (!d.longitude_deg) d.longitude_deg = tags.dji_real("GpsLongtitude");  // as some firmware spells it
  d.altitude_type = tags.dji_text("AltitudeType");
  d.dewarp_data = tags.dji_text("DewarpData");
  d.dewarped = base::parse_integer(tags.dji_text("DewarpFlag")).value_or(0) == 1;
  d.camera_reversed = base::parse_integer(tags.dji_text("CamReverse")).value_or(0) == 1;
  return d;
}

ImageMetadata metadata_of(const Exiv2::Image& image, const ImageSize& size, std::string_view name) {
  const Tags tags(image.exifData(), image.xmpData());
  ImageMetadata m;
  m.size = size;
  const auto width = tags.positive("Exif.Photo.PixelXDimension"), height = tags.positive("Exif.Photo.PixelYDimension");
  if (width && height && *width < 1e9 && *height < 1e9)
    m.exif_size = ImageSize{std::llround(*width), std::llround(*height)};
  m.make = tags.text("Exif.Image.Make");
  m.model = tags.text("Exif.Image.Model");
  m.software = tags.text("Exif.Image.Software");
  m.civil_time_ns = civil_time(tags);
  const double orientation = tags.real("Exif.Image.Orientation").value_or(1.0);
  m.orientation = orientation >= 1.0 && orientation <= 8.0 ? static_cast<int>(orientation) : 1;
  m.focal_length_mm = tags.positive("Exif.Photo.FocalLength");
  m.focal_length_35mm_mm = tags.positive("Exif.Photo.FocalLengthIn35mmFilm");
  m.exposure_s = tags.positive("Exif.Photo.ExposureTime");
  m.latitude_deg = angle_of(tags, "Exif.GPSInfo.GPSLatitude", "Exif.GPSInfo.GPSLatitudeRef", "S");
  m.longitude_deg = angle_of(tags, "Exif.GPSInfo.GPSLongitude", "Exif.GPSInfo.GPSLongitudeRef", "W");
  if (!m.latitude_deg || !m.longitude_deg) m.latitude_deg = m.longitude_deg = std::nullopt;
  require_on_globe(m.latitude_deg, 90.0, "latitude", name);
  require_on_globe(m.longitude_deg, 180.0, "longitude", name);
  if (const auto ref = tags.real("Exif.GPSInfo.GPSAltitudeRef"); ref && *ref >= 0.0 && *ref <= 255.0)
    m.gps_altitude_ref = static_cast<int>(*ref);
  m.gps_altitude_m = tags.real("Exif.GPSInfo.GPSAltitude");
  // Exif 2.2: 1 = below sea level; Exif 3.0 adds 3 with the same sign.
  if (m.gps_altitude_m && (m.gps_altitude_ref == 1 || m.gps_altitude_ref == 3)) m.gps_altitude_m = -*m.gps_altitude_m;
  m.dji = dji_of(tags);
  require_on_globe(m.dji.latitude_deg, 90.0, "latitude", name);
  require_on_globe(m.dji.longitude_deg, 180.0, "longitude", name);
  return m;
}

template <typename Open>
ImageMetadata guarded(Open&& open, const ImageSize& size, std::string_view name) {
  const std::lock_guard hold(exiv2_lock());
  std::string why;
  try {
    prepare_exiv2();
    const auto image = open();
    image->readMetadata();
    return metadata_of(*image, size, name);
  } catch (const Error&) {
    throw;
  } catch (const std::exception& e) {
    why = e.what();
  } catch (...) {
    why = "unknown fault";
  }
  throw Error(ErrorCode::invalid_input, "image metadata cannot be read: " + why)
      .file(name)
      .hint("The image is damaged; copy it again or leave it out");
}

}  // namespace

ImageMetadata read_image_metadata(const std::filesystem::path& path) {
  const ImageHeader header = read_image_header(path);
  constexpr std::uintmax_t kMaxBytes = std::uintmax_t{1} << 30;
  std::error_code code;
  if (std::filesystem::file_size(path, code) > kMaxBytes)
    throw Error(ErrorCode::invalid_input, "image file too large").file(path.string()).allowed("at most 1 GiB");
  return guarded([&] { return Exiv2::ImageFactory::open(path.string()); }, {header.width_px, header.height_px},
                 path.string());
}

ImageMetadata image_metadata_of(std::string_view bytes, std::string_view name) {
  return guarded(
      [&] {
        const auto* data = static_cast<const Exiv2::byte*>(static_cast<const void*>(bytes.data()));
        return Exiv2::ImageFactory::open(data, static_cast<long>(bytes.size()));
      },
      {}, name);
}

}  // namespace cairn::io
