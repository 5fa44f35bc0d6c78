// OpenSfM or OpenDroneMap reconstruction -> survey.
#pragma once

#include <filesystem>

#include "pipeline/import_survey.hpp"

namespace cairn::pipeline {

struct ImportOpensfmInputs {
  ImportInputs common;           // origin: over the reconstruction's own reference; height_type: of its altitude
  std::filesystem::path input;   // reconstruction.json, or a project's folder
  std::filesystem::path tracks;  // "" = tracks.csv beside the reconstruction
  std::filesystem::path images;  // "" = the folder `images` of the project where there is one, else no images are named
};

// The reconstruction's frame is taken as east-north-up metres about its reference. Intrinsics and tie observations are
// in the pixels of the cameras' size; image files of another size are scaled to (each camera by its own factor). The
// altitude of the reference is what the EXIF tags hold: without --height-type the datum is unknown. Throws not_found
// naming missing images, invalid_argument without any reference, failed_precondition for an image whose proportions are
// not its camera's.
[[nodiscard]] Outcome import_opensfm(const ImportOpensfmInputs& in, const std::filesystem::path& out,
                                     base::RunContext& ctx);

}  // namespace cairn::pipeline
