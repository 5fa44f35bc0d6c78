#include "pipeline/survey_sources.hpp"

#include <cmath>
#include <set>

#include "base/error.hpp"
#include "base/number_text.hpp"
#include "base/parallel.hpp"
#include "geodesy/crs.hpp"
#include "geodesy/local_frame.hpp"
#include "io/cloud.hpp"
#include "io/survey_folder.hpp"

namespace cairn::pipeline {
namespace fs = std::filesystem;
namespace {

using base::Error;
using base::ErrorCode;

// Stages work within about 10 km of the origin (design, section 3); beyond twice that it is another place.
constexpr double kFarthest_m = 20'000.0;

void refuse_far_cloud(const geometry::PointCloud& cloud, const fs::path& path, const std::string& crs) {
  geometry::Box3 box;
  for (const auto& p : cloud.positions) box.extend(p);
  const geometry::Vec3 centre = box.centre();
  const double distance = std::hypot(centre.x(), centre.y());
  if (distance <= kFarthest_m) return;
  throw Error(ErrorCode::crs_mismatch, "the cloud does not lie where the survey is")
      .file(path.string())
      .found(base::to_fixed(distance / 1000.0, 1) + " km from the survey's origin, read as " + crs)
      .allowed("at most " + base::to_fixed(kFarthest_m / 1000.0, 0) + " km")
      .hint("Import again with the right --cloud-crs");
}

// Units that the file states beside its CRS (LAS unit keys). Taking feet for metres would scale the survey.
void refuse_other_units(const io::SourceFacts& facts, const std::string& crs, const fs::path& path) {
  constexpr double kSameUnit = 1e-6;  // relative; the two feet differ by 2e-6
  geodesy::CrsInfo info;
  if (crs != "local") info = geodesy::describe_crs(crs);
  const auto check = [&](const char* axis, double stated, double declared) {
    if (stated == 0.0 || std::abs(stated / declared - 1.0) < kSameUnit) return;
    throw Error(ErrorCode::crs_mismatch, std::string("the cloud states another ") + axis + " unit than its CRS has")
        .file(path.string())
        .found(base::to_text(stated) + " m a unit")
        .allowed(base::to_text(declared) + " m a unit, as in " + (crs == "local" ? crs : info.name))
        .hint("Import again with the --cloud-crs that the coordinates really are in");
  };
  if (!info.geographic) check("horizontal", facts.horizontal_unit_m, info.horizontal_unit_m);
  check("vertical", facts.vertical_unit_m, info.has_vertical ? info.vertical_unit_m : 1.0);
}

}  // namespace

bool has_cloud(const survey::Survey& survey) {
  return survey.source("cloud") != nullptr;
}

SurveyCloud load_cloud(const fs::path& survey_folder, const survey::Survey& survey, base::RunContext& ctx) {
  const survey::Source* source = survey.source("cloud");
  if (source == nullptr)
    throw Error(ErrorCode::not_found, "the survey has no point cloud")
        .file((survey_folder / "survey.json").string())
        .hint("Import it again with --cloud");
  SurveyCloud result;
  result.path = io::resolve_reference(source->path, survey_folder);
  std::error_code no_size;
  const auto bytes = fs::file_size(result.path, no_size);
  // A point of 20 to 30 bytes on disk takes up to 150 in memory with its columns.
  if (!no_size) ctx.check_memory(6 * bytes, "the cloud " + result.path.filename().string());
  io::CloudFile data = io::read_cloud(result.path);
  if (data.cloud.empty())
    throw Error(ErrorCode::invalid_input, "the cloud has no points").file(result.path.string()).allowed("at least 1");
  for (const auto& warning : data.facts.warnings) ctx.warn(result.path.filename().string() + ": " + warning);
  result.cloud = std::move(data.cloud);

  const std::string crs = source->crs.empty() ? data.facts.crs : source->crs;
  if (crs.empty())
    throw Error(ErrorCode::crs_mismatch, "the cloud declares no coordinate reference system")
        .file(result.path.string())
        .hint("Import again with --cloud-crs EPSG:n, or --cloud-crs local where it is in the survey's own frame");
  refuse_other_units(data.facts, crs, result.path);
  if (crs != "local") {
    const geodesy::LocalFrame frame(survey.manifest.origin.position);
    const geodesy::CrsConverter converter(crs, frame);
    converter.to_local(result.cloud.positions);
    result.operation = converter.operation();
  }
  if (source->height_type == survey::HeightType::unknown)
    ctx.warn(result.path.filename().string() + ": no vertical datum is declared; its heights are taken as " +
             std::string(survey::name_of(survey.manifest.origin.height_type)) + ", like the survey's");
  if (source->T_world_source) {
    const geometry::Similarity T = *source->T_world_source;
    auto& positions = result.cloud.positions;
    base::parallel_for(positions.size(), 65536, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) positions[i] = T * positions[i];
    });
  }
  refuse_far_cloud(result.cloud, result.path, crs);
  return result;
}

std::vector<fs::path> survey_files(const fs::path& survey_folder, const survey::Survey& survey) {
  std::set<fs::path> files;
  // `prior` holds the map that a ground vehicle had before.
  for (const auto& folder : {survey_folder, survey_folder / "prior"}) {
    if (!fs::is_directory(folder)) continue;
    for (const auto& entry : fs::directory_iterator(folder))
      if (entry.is_regular_file() && entry.path().filename() != "run.json") files.insert(entry.path());
  }
  const auto add = [&](const std::string& reference, const std::string& record) {
    const fs::path path = io::resolve_reference(reference, survey_folder).lexically_normal();
    if (path.empty() || fs::is_directory(path)) return;
    if (!fs::is_regular_file(path))
      throw Error(ErrorCode::not_found, "a file of the survey is missing")
          .file(path.string())
          .record(record)
          .hint("Put it back, or import the survey again");
    files.insert(path);
  };
  for (const auto& source : survey.manifest.sources)
    if (source.kind == "cloud") add(source.path, "source 'cloud' of survey.json");
  for (const auto& frame : survey.frames)
    add(frame.image, "frame " + std::to_string(frame.id.value) + " of frames.csv");
  return {files.begin(), files.end()};
}

}  // namespace cairn::pipeline
