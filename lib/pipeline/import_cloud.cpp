// The cloud of a survey, by reference: only its header is read here.
#include "base/error.hpp"
#include "base/number_text.hpp"
#include "geodesy/crs.hpp"
#include "io/las.hpp"
#include "io/survey_folder.hpp"
#include "pipeline/import_survey.hpp"

namespace cairn::pipeline {

void attach_cloud(Imported& imported, const ImportInputs& in) {
  const io::LasReader reader(in.cloud);
  const std::string& declared = reader.metadata().crs;
  survey::Source source;
  source.kind = "cloud";
  source.path = io::file_reference(in.cloud, in.survey_folder);
  source.height_type = in.cloud_height_type;
  source.crs = in.cloud_crs.empty() ? declared : in.cloud_crs;
  if (source.crs.empty())
    throw base::Error(base::ErrorCode::crs_mismatch, "the cloud declares no CRS")
        .file(in.cloud.string())
        .allowed("a CRS in the file, or --cloud-crs")
        .hint("Add --cloud-crs EPSG:n, or --cloud-crs local where the cloud is in the survey's own metres");
  if (source.crs != "local") (void)geodesy::describe_crs(source.crs);  // refuses what PROJ cannot read
  source.convention = source.crs == "local"  ? "Coordinates in the survey's own local frame, "
                      : in.cloud_crs.empty() ? "Coordinates in the CRS the file declares, "
                                             : "Coordinates in the CRS given at import, ";
  source.convention += "heights " + std::string(survey::name_of(in.cloud_height_type)) +
                       (in.cloud_height_type == survey::HeightType::unknown ? " (no vertical datum is declared)" : "") +
                       ".";
  if (!in.similarity.empty()) {
    source.T_world_source = read_similarity(in.similarity, imported.survey.manifest.origin);
    source.convention += " The cloud does not share the poses' frame: it is moved by the similarity of " +
                         in.similarity.filename().string() + " after conversion to the local frame.";
  }
  imported.survey.manifest.sources.push_back(std::move(source));
}

}  // namespace cairn::pipeline
