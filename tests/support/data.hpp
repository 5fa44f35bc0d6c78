// Where tests find inputs and put outputs.
#pragma once

#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <string>
#include <string_view>

namespace cairn::testing {

// The project's own licensed test inputs: tests/data and samples.
inline std::filesystem::path source_dir() {
  return CAIRN_SOURCE_DIR;
}
inline std::filesystem::path test_data(std::string_view name) {
  return source_dir() / "tests/data" / name;
}
inline std::filesystem::path sample(std::string_view name) {
  return source_dir() / "samples" / name;
}

// A fresh folder that goes away with the object.
class TempFolder {
 public:
  TempFolder() {
    std::string pattern = (std::filesystem::temp_directory_path() / "cairn-test-XXXXXX").string();
    path_ = ::mkdtemp(pattern.data());
  }
  ~TempFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TempFolder(const TempFolder&) = delete;
  TempFolder& operator=(const TempFolder&) = delete;
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  [[nodiscard]] std::filesystem::path operator/(std::string_view name) const { return path_ / name; }

 private:
  std::filesystem::path path_;
};

}  // namespace cairn::testing
