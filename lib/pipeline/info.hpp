// What is this file? One description for every kind that cairn reads.
#pragma once

#include <filesystem>

#include "base/options.hpp"
#include "io/json.hpp"

namespace cairn::pipeline {

struct InfoOptions {
  // Read every point of a LAS file whatever its size. Off: above 64 MiB the header alone answers.
  bool full = false;

  void visit(base::OptionVisitor& visitor) {
    visitor.flag("full", full, "Read every point; without it large LAS files are described by their header");
  }
};

// An object with `path`, `kind` ("cloud", "mesh", "raster", "vector", "image", "ros_map", "survey",
// "colmap_model", "run", "json"), `format`, and the members of docs/commands/info.md for that kind;
// always `warnings`, a list of sentences. Recognised by content first, then by extension.
// Throws not_found, or invalid_input naming the place, or all kinds where none fits.
// Cost: clouds and meshes are read whole (large LAS files: the header), the others their header.
[[nodiscard]] io::Json file_info(const std::filesystem::path& path, const InfoOptions& options = {});

}  // namespace cairn::pipeline
