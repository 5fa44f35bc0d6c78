// SHA-256 of files and texts: what resuming and run.json go by (never times).
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

namespace cairn::base {

class Digest {
 public:
  Digest();
  ~Digest();
  Digest(Digest&&) noexcept;
  Digest& operator=(Digest&&) noexcept;

  Digest& add(std::string_view bytes);
  // A field with its length before it, so that ("ab","c") and ("a","bc") differ.
  Digest& add_field(std::string_view bytes);
  // 64 lower-case hex digits; the object is spent.
  [[nodiscard]] std::string hex() &&;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

[[nodiscard]] std::string sha256_of(std::string_view text);
// Streams the file; throws not_found.
[[nodiscard]] std::string sha256_of_file(const std::filesystem::path& path);

}  // namespace cairn::base
