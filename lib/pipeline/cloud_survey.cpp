#include "pipeline/cloud_survey.hpp"

#include <array>
#include <cmath>

#include "base/error.hpp"
#include "base/number_text.hpp"
#include "geodesy/crs.hpp"
#include "io/cloud.hpp"
#include "io/survey_folder.hpp"

namespace cairn::pipeline {
namespace fs = std::filesystem;
namespace {

using base::Error;
using base::ErrorCode;

geometry::Box3 bounds_of(const fs::path& cloud, std::string& crs) {
  if (io::recognise_cloud(cloud) == io::CloudFormat::las) {
    const io::LasReader reader(cloud);
    crs = reader.metadata().crs;
    if (reader.metadata().point_count > 0) return reader.metadata().bounds;
  } else {
    const auto file = io::read_cloud(cloud);
    crs = file.facts.crs;
    geometry::Box3 box;
    for (const auto& p : file.cloud.positions) box.extend(p);
    if (!file.cloud.empty()) return box;
  }
  throw Error(ErrorCode::invalid_input, "the cloud has no points").file(cloud.string()).allowed("at least 1");
}

}  // namespace

geometry::Geodetic parse_origin(std::string_view text) {
  std::array<double, 3> values{};
  std::string_view rest = text;
  bool good = true;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto comma = rest.find(',');
    const auto value = base::parse_real(rest.substr(0, comma));
    good = good && value && std::isfinite(*value) && (comma != std::string_view::npos) == (i < 2);
    if (!good) break;
    values[i] = *value;
    rest = comma == std::string_view::npos ? std::string_view() : rest.substr(comma + 1);
  }
  if (!good || std::abs(values[0]) > 90.0 || std::abs(values[1]) > 180.0)
    throw Error(ErrorCode::invalid_argument, "--origin is not a position")
        .found("'" + std::string(text) + "'")
        .allowed("latitude,longitude,height: 46.8426,-91.9940,158");
  return {values[0], values[1], values[2]};
}

void write_cloud_survey(const fs::path& cloud, const std::optional<geometry::Geodetic>& origin,
                        const fs::path& folder) {
  std::string crs;
  const geometry::Box3 box = bounds_of(cloud, crs);
  survey::Survey survey;
  survey.manifest.name = cloud.stem().string();
  survey::Source source;
  source.kind = "cloud";
  source.path = fs::absolute(cloud).lexically_normal().string();
  if (crs.empty()) {
    if (!origin)
      throw Error(ErrorCode::crs_mismatch, "the cloud declares no coordinate reference system")
          .file(cloud.string())
          .allowed("a CRS in the file, or --origin")
          .hint("Give --origin latitude,longitude,height of the cloud's zero point, or convert the cloud to a CRS");
    survey.manifest.origin = {*origin, survey::HeightType::unknown, ""};
    source.crs = "local";
    source.convention = "Coordinates in metres east, north, up of the origin given.";
  } else {
    const auto info = geodesy::describe_crs(crs);
    const auto type = info.has_vertical ? survey::HeightType::ellipsoidal : survey::HeightType::unknown;
    geometry::Geodetic centre{0.0, 0.0, 0.0};
    if (origin) {
      centre = *origin;
    } else {
      // Twice: the best operation depends on the place, which is known better the second time.
      for (int pass = 0; pass < 2; ++pass) {
        const geodesy::LocalFrame frame({centre.latitude_deg, centre.longitude_deg, 0.0});
        centre = frame.to_geodetic(geodesy::CrsConverter(crs, frame).to_local(box.centre()));
      }
      constexpr double kStep_deg = 1e-5;  // about a metre: a position that people can write down
      centre.latitude_deg = std::round(centre.latitude_deg / kStep_deg) * kStep_deg;
      centre.longitude_deg = std::round(centre.longitude_deg / kStep_deg) * kStep_deg;
      centre.height_m = std::round(centre.height_m);
    }
    survey.manifest.origin = {centre, type, ""};
    source.crs = crs;
    source.height_type = type;
    source.convention = "Coordinates in the CRS the file declares.";
  }
  survey.manifest.sources.push_back(std::move(source));
  survey.manifest.notes = {"A cloud by itself: no photographs, no detections."};
  io::write_survey(survey, folder);
}

}  // namespace cairn::pipeline
