// What every use of GDAL in cairn shares: few drivers, no network, no sidecar files, errors caught.
// Private to the adapters.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "base/error.hpp"

namespace cairn::io {

// Registers the drivers cairn needs (GTiff, COG, MEM, GPKG, GeoJSON, ESRI Shapefile), once. VRT, the
// network drivers and all others stay unregistered, so that no file can reach them.
void start_gdal();

// Collects GDAL's messages of this thread while it lives; nothing is printed.
class GdalMessages {
 public:
  GdalMessages();
  ~GdalMessages();
  GdalMessages(const GdalMessages&) = delete;
  GdalMessages& operator=(const GdalMessages&) = delete;

  [[nodiscard]] bool failed() const { return !failure_.empty(); }
  [[nodiscard]] const std::string& failure() const { return failure_; }
  [[nodiscard]] const std::string& warning() const { return warning_; }
  void add(bool is_failure, std::string_view text);

  // Throws with GDAL's first failure in the message.
  [[noreturn]] void raise(base::ErrorCode code, std::string message, const std::filesystem::path& path) const;

 private:
  std::string failure_, warning_;  // the first of each
};

// The path to hand to GDAL: absolute, and an existing regular file; throws not_found otherwise. So
// neither URLs nor /vsi... names get through.
[[nodiscard]] std::string gdal_input_path(const std::filesystem::path& path);

// A file in GDAL's memory, removed with the object. Names are unique within the process.
class MemoryFile {
 public:
  explicit MemoryFile(std::string_view extension);
  ~MemoryFile();
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;

  [[nodiscard]] const std::string& path() const { return path_; }
  // Empty where the file is not there.
  [[nodiscard]] std::string_view bytes() const;

 private:
  std::string folder_, path_;
};

}  // namespace cairn::io
