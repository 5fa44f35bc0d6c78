#include "pipeline/check_cloud.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "adjustment/cloud_surface.hpp"
#include "adjustment/robust.hpp"
#include "base/number_text.hpp"
#include "geodesy/crs.hpp"
#include "geodesy/local_frame.hpp"
#include "geometry/primitives.hpp"
#include "io/cloud.hpp"
#include "io/survey_folder.hpp"

namespace cairn::pipeline {
namespace fs = std::filesystem;
namespace {

using base::Error;
using base::to_fixed;
using geometry::Vec2;
using geometry::Vec3;
using io::Json;

constexpr double kFoot = 0.3048;  // m; the US survey foot differs by 2e-6, nothing here can see it

// How a sample of the cloud lies against the cameras and tie points.
struct Fit {
  bool converted = false;   // the CRS could be applied at all
  double distance_m = 0.0;  // between the outlines (horizontal) of cloud and cameras; 0 = they overlap
  double up_m = 0.0;        // median of cloud - tie points; without ties, of cloud - (cameras - 50 m)
  bool by_ties = false;

  [[nodiscard]] bool near(double most) const { return converted && distance_m <= most; }
};

struct Reading {
  std::string crs;
  double scale_xy = 1.0, scale_z = 1.0;
  bool swapped = false;
};

double gap(double lo_a, double hi_a, double lo_b, double hi_b) {
  return std::max({0.0, lo_a - hi_b, lo_b - hi_a});
}

class Prober {
 public:
  Prober(const CheckedSurvey& checked, const survey::Source& source, const geometry::PointCloud& cloud)
      : survey_(checked.survey), source_(source), local_(checked.survey.manifest.origin.position) {
    constexpr std::size_t kSample = 20000;
    const std::size_t step = std::max<std::size_t>(1, cloud.size() / kSample);
    for (std::size_t i = 0; i < cloud.size(); i += step) sample_.push_back(cloud.positions[i]);
    for (const auto& frame : survey_.frames) cameras_.extend(frame.T_world_camera.translation);
  }

  [[nodiscard]] Fit fit(const Reading& reading) const {
    Fit result;
    geometry::PointCloud local;
    try {
      local.positions = converted(reading);
    } catch (const Error&) {
      return result;
    }
    geometry::Box3 box;
    for (const auto& p : local.positions)
      if (p.allFinite()) box.extend(p);
    if (box.empty() || cameras_.empty()) return result;
    result.converted = true;
    result.distance_m = std::hypot(gap(box.min.x(), box.max.x(), cameras_.min.x(), cameras_.max.x()),
                                   gap(box.min.y(), box.max.y(), cameras_.min.y(), cameras_.max.y()));
    std::vector<double> up;
    constexpr double kFar = 50'000.0;  // m: no surface of a cloud on the other side of the Earth
    if (result.distance_m < kFar) {
      constexpr std::size_t kCells = 250'000;
      const auto surface = adjustment::cloud_surface(local, 0.0, 2, kCells);
      for (const auto& tie : survey_.ties)
        if (const auto height = surface.height_at(tie.p_world.head<2>())) up.push_back(*height - tie.p_world.z());
    }
    constexpr std::size_t kLeast = 20;
    result.by_ties = up.size() >= kLeast;
    if (result.by_ties) {
      result.up_m = adjustment::median(std::move(up));
    } else {
      std::vector<double> heights;
      for (const auto& p : local.positions) heights.push_back(p.z());
      constexpr double kUsualHeight = 50.0;
      result.up_m = adjustment::median(std::move(heights)) - (cameras_.centre().z() - kUsualHeight);
    }
    return result;
  }

 private:
  [[nodiscard]] std::vector<Vec3> converted(const Reading& reading) const {
    std::vector<Vec3> points = sample_;
    for (auto& p : points) {
      if (reading.swapped) std::swap(p.x(), p.y());
      p = Vec3(reading.scale_xy * p.x(), reading.scale_xy * p.y(), reading.scale_z * p.z());
    }
    if (reading.crs != "local") geodesy::CrsConverter(reading.crs, local_).to_local(points);
    if (source_.T_world_source)
      for (auto& p : points) p = *source_.T_world_source * p;
    return points;
  }

  const survey::Survey& survey_;
  const survey::Source& source_;
  geodesy::LocalFrame local_;
  std::vector<Vec3> sample_;
  geometry::Box3 cameras_;
};

std::string utm_zone(const geometry::Geodetic& origin) {
  const int zone = std::clamp(static_cast<int>(std::floor((origin.longitude_deg + 180.0) / 6.0)) + 1, 1, 60);
  return "EPSG:" + std::to_string((origin.latitude_deg < 0.0 ? 32700 : 32600) + zone);
}

std::string place_of(const Fit& fit) {
  if (!fit.converted) return "outside the area of the coordinate reference system";
  if (fit.distance_m >= 1000.0) return to_fixed(fit.distance_m / 1000.0, 1) + " km from the cameras";
  return to_fixed(fit.distance_m, 0) + " m from the cameras";
}

// Names the reading that puts a distant cloud where the survey is.
void explain_distance(const Prober& prober, const Reading& declared, const Fit& fit, const survey::Survey& survey,
                      const std::string& file, const CheckOptions& options, Findings& findings) {
  const double most = options.max_cloud_distance_m;
  const std::string found = place_of(fit) + ", read as " + declared.crs;
  const std::string allowed = "at most " + to_fixed(most, 0) + " m";
  const auto is_near = [&](const Reading& reading) { return prober.fit(reading).near(most); };
  const Reading feet{declared.crs, kFoot, kFoot, false};
  if (is_near(feet) || is_near({declared.crs, kFoot, 1.0, false})) {
    findings.add(
        {"cloud_in_feet", Severity::error, file, "coordinates",
         told("the cloud's coordinates are in feet, its coordinate reference system in metres", found, allowed),
         "Read in feet it lies on the survey: convert the cloud to metres (cairn convert), or declare the CRS "
         "with feet"});
    return;
  }
  for (const std::string& crs : {utm_zone(survey.manifest.origin.position), std::string("EPSG:4326")})
    if (crs != declared.crs && is_near({crs, 1.0, 1.0, false})) {
      findings.add({"cloud_wrong_crs", Severity::error, file, "coordinate reference system",
                    told("the cloud is declared in the wrong coordinate reference system", found, allowed),
                    "Read as " + crs + " it lies on the survey: import again with --cloud-crs " + crs});
      return;
    }
  if (is_near({declared.crs, 1.0, 1.0, true})) {
    findings.add({"cloud_wrong_crs", Severity::error, file, "axis order",
                  told("the cloud's first two coordinates are swapped", found, allowed),
                  "Read as northing, easting it lies on the survey: swap x and y"});
    return;
  }
  findings.add({"cloud_far_from_survey", Severity::error, file, "coordinates",
                told("the cloud does not lie where the survey is", found, allowed),
                "Check that the cloud belongs to this survey, and its coordinate reference system (--cloud-crs at "
                "import)"});
}

void check_heights_unit(const Prober& prober, const Reading& declared, const Fit& fit, const std::string& file,
                        Findings& findings) {
  constexpr double kFarUp = 30.0;  // m beyond which heights are of another unit or datum
  const double limit = fit.by_ties ? kFarUp : 4.0 * kFarUp;
  if (std::abs(fit.up_m) <= limit) return;
  Reading feet = declared;
  feet.scale_z = kFoot;
  const Fit in_feet = prober.fit(feet);
  const std::string found = "a median of " + to_fixed(fit.up_m, 1) + " m above " +
                            (fit.by_ties ? "the tie points" : "the ground expected below the cameras");
  const std::string allowed = "within " + to_fixed(limit, 0) + " m";
  if (in_feet.converted && std::abs(in_feet.up_m) < 0.2 * std::abs(fit.up_m)) {
    findings.add({"cloud_heights_in_feet", Severity::error, file, "z",
                  told("the cloud's heights are in feet, taken for metres", found, allowed),
                  "Read in feet they fit (" + to_fixed(in_feet.up_m, 1) +
                      " m): convert z to metres, or declare a vertical CRS with feet"});
    return;
  }
  findings.add(
      {"cloud_heights_differ", Severity::error, file, "z",
       told("the cloud's heights do not fit the survey's", found, allowed),
       "Check the vertical datum of both (ellipsoidal or orthometric: they differ by the geoid), and that the "
       "poses were not read inverted; give --takeoff-height where the poses' heights are relative to the take-off"});
}

std::optional<std::string> crs_of(const survey::Source& source, const std::string& in_file, const std::string& file,
                                  Findings& findings) {
  if (source.crs.empty() && in_file.empty()) {
    findings.add({"cloud_no_crs", Severity::error, file, "coordinate reference system",
                  "the cloud declares no coordinate reference system (found none in the file nor in survey.json; "
                  "allowed EPSG:n, WKT, or local)",
                  "Import again with --cloud-crs EPSG:n, or --cloud-crs local where it is in the survey's own frame"});
    return std::nullopt;
  }
  return source.crs.empty() ? in_file : source.crs;
}

// Units that the file states beside its CRS: where they differ, nobody knows what the numbers are.
bool units_agree(const io::SourceFacts& facts, const geodesy::CrsInfo& info, const std::string& file,
                 Findings& findings) {
  constexpr double kSameUnit = 1e-6;  // relative; the two feet differ by 2e-6
  bool agree = true;
  const auto check = [&](const char* axis, double stated, double declared) {
    if (stated == 0.0 || std::abs(stated / declared - 1.0) < kSameUnit) return;
    agree = false;
    findings.add({"cloud_units_contradict", Severity::error, file, std::string(axis) + " unit",
                  told("the cloud states another unit than its coordinate reference system has",
                       base::to_text(stated) + " m a unit", base::to_text(declared) + " m a unit"),
                  "Import again with the --cloud-crs that the coordinates really are in"});
  };
  if (!info.geographic) check("horizontal", facts.horizontal_unit_m, info.horizontal_unit_m);
  check("vertical", facts.vertical_unit_m, info.has_vertical ? info.vertical_unit_m : 1.0);
  return agree;
}

}  // namespace

std::optional<CheckedCloud> check_cloud(const CheckedSurvey& checked, const fs::path& folder,
                                        const CheckOptions& options, Findings& findings, Json& evidence) {
  const survey::Source* source = checked.survey.source("cloud");
  if (source == nullptr) return std::nullopt;
  CheckedCloud result;
  result.path = io::resolve_reference(source->path, folder);
  result.has_similarity = source->T_world_source.has_value();
  const std::string file = result.path.string();
  std::error_code code;
  if (!fs::exists(result.path, code)) {
    findings.add({"cloud_missing", Severity::error, file, "source 'cloud' of survey.json",
                  told("the cloud is missing", "no file", "a LAS, PLY, PCD, OBJ or text cloud"),
                  "Put the cloud back, or import again with --cloud"});
    return std::nullopt;
  }
  io::CloudFile data;
  try {
    io::LasColumns columns = io::LasColumns::positions_only();
    columns.colours = true;
    data = io::read_cloud(result.path, columns);
  } catch (Error& error) {
    error.default_file(file);
    findings.add("cloud_unreadable", error, "source 'cloud' of survey.json");
    return std::nullopt;
  }
  for (const auto& warning : data.facts.warnings)
    findings.add({"cloud_file_note", Severity::info, file, "", warning, ""});
  Json facts = Json::object({{"points", data.cloud.size()}, {"format", data.facts.format}});
  if (data.cloud.empty()) {
    findings.add({"cloud_empty", Severity::error, file, "points",
                  told("the cloud has no points", "0 points", "at least 1"), "Export the cloud again"});
    return std::nullopt;
  }
  const auto crs = crs_of(*source, data.facts.crs, file, findings);
  if (!crs) return std::nullopt;
  facts.set("crs", *crs);
  geodesy::CrsInfo info;
  info.has_vertical = *crs == "local";
  if (*crs != "local") {
    try {
      info = geodesy::describe_crs(*crs);
      const geodesy::CrsConverter probe(*crs, geodesy::LocalFrame(checked.survey.manifest.origin.position));
      facts.set("operation", probe.operation());
    } catch (Error& error) {
      error.default_file(file);
      findings.add("cloud_crs_invalid", error, "coordinate reference system");
      return std::nullopt;
    }
  }
  if (!units_agree(data.facts, info, file, findings)) return std::nullopt;
  if (!info.has_vertical && source->height_type == survey::HeightType::unknown)
    findings.add({"cloud_no_vertical_datum", Severity::warning, file, "heights",
                  "the cloud's heights have no declared datum (found " + (info.name.empty() ? *crs : info.name) +
                      " without a vertical part; allowed a compound CRS, or a height type in survey.json)",
                  "Name it: import again with --cloud-height-type, or a compound --cloud-crs EPSG:n+m. Until then "
                  "heights are taken in the "
                  "survey's own datum"});
  if (data.cloud.colours.empty())
    findings.add({"cloud_no_colours", Severity::info, file, "colours",
                  "the cloud has no colours: its horizontal place could not be proved against the images",
                  "Export the cloud with colours to have it proved"});
  if (!checked.has_origin || checked.survey.frames.empty()) return std::nullopt;

  const Prober prober(checked, *source, data.cloud);
  const Reading declared{*crs, 1.0, 1.0, false};
  const Fit fit = prober.fit(declared);
  if (fit.converted) facts.set("distance_to_cameras_m", fit.distance_m);
  evidence.set("cloud_file", std::move(facts));
  if (!fit.near(options.max_cloud_distance_m)) {
    explain_distance(prober, declared, fit, checked.survey, file, options, findings);
    return std::nullopt;
  }
  const std::size_t before = findings.count(Severity::error);
  check_heights_unit(prober, declared, fit, file, findings);
  const bool sound_heights = findings.count(Severity::error) == before;
  try {
    if (*crs != "local")
      geodesy::CrsConverter(*crs, geodesy::LocalFrame(checked.survey.manifest.origin.position))
          .to_local(data.cloud.positions);
  } catch (Error& error) {
    error.default_file(file);
    findings.add("cloud_crs_invalid", error, "points");
    return std::nullopt;
  }
  if (source->T_world_source)
    for (auto& p : data.cloud.positions) p = *source->T_world_source * p;
  if (!sound_heights) return std::nullopt;
  result.cloud = std::move(data.cloud);
  return result;
}

}  // namespace cairn::pipeline
