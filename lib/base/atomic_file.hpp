// Outputs appear under their final name only when complete.
#pragma once

#include <filesystem>
#include <span>
#include <string_view>

namespace cairn::base {

// A temporary path beside the final one. Write the file there by any means, then commit():
// fsync the file, rename it, fsync the folder. Without commit the temporary is removed.
//
//     StagedFile staged(out / "surface.tif", overwrite);
//     write_geotiff(staged.path(), ...);
//     staged.commit();
class StagedFile {
 public:
  // Throws already_exists where the final file is there and overwrite is false, and
  // resource_exhausted where the folder cannot be written.
  // The temporary keeps the extension (some writers choose the format by it).
  explicit StagedFile(std::filesystem::path final_path, bool overwrite = true);
  ~StagedFile();
  StagedFile(const StagedFile&) = delete;
  StagedFile& operator=(const StagedFile&) = delete;

  [[nodiscard]] const std::filesystem::path& path() const noexcept { return temporary_; }
  void commit();

 private:
  std::filesystem::path final_, temporary_;
  bool committed_ = false;
};

// A temporary folder beside the final one, published by one rename.
// commit() replaces an existing final folder only where overwrite was given.
class StagedFolder {
 public:
  explicit StagedFolder(std::filesystem::path final_path, bool overwrite = false);
  ~StagedFolder();
  StagedFolder(const StagedFolder&) = delete;
  StagedFolder& operator=(const StagedFolder&) = delete;

  [[nodiscard]] const std::filesystem::path& path() const noexcept { return temporary_; }
  void commit();

 private:
  std::filesystem::path final_, temporary_;
  bool committed_ = false;
  bool overwrite_ = false;
};

// The whole content at once, atomically. Every failed write throws resource_exhausted with
// the path and the number of bytes; an existing file is left as it was.
void write_file_atomic(const std::filesystem::path& path, std::string_view content, bool overwrite = true);

// Plain (not atomic) write inside a staged folder; checks every byte.
void write_file(const std::filesystem::path& path, std::string_view content);

// The whole file. Throws not_found, or invalid_input where it is larger than max_bytes.
[[nodiscard]] std::string read_file(const std::filesystem::path& path,
                                    std::uintmax_t max_bytes = std::uintmax_t{1} << 34);

// fsync of every regular file below a folder and of the folders; for StagedFolder.
void sync_tree(const std::filesystem::path& folder);

}  // namespace cairn::base
