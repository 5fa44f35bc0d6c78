#include "base/atomic_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string>
#include <utility>

#include "base/error.hpp"

namespace cairn::base {
namespace fs = std::filesystem;
namespace {

Error io_error(const fs::path& path, const std::string& what, int code) {
  return Error(ErrorCode::resource_exhausted, what + ": " + std::strerror(code))
      .file(path.string())
      .hint(code == ENOSPC ? "Free some disk space and run again" : "Check that the folder exists and can be written");
}

class Descriptor {
 public:
  explicit Descriptor(int fd) : fd_(fd) {}
  ~Descriptor() {
    if (fd_ >= 0) ::close(fd_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  [[nodiscard]] int get() const { return fd_; }
  [[nodiscard]] int release() { return std::exchange(fd_, -1); }

 private:
  int fd_;
};

void sync_path(const fs::path& path, int flags) {
  Descriptor file(::open(path.c_str(), flags | O_CLOEXEC));
  if (file.get() < 0) throw io_error(path, "cannot open to flush", errno);
  if (::fsync(file.get()) != 0 && errno != EINVAL) throw io_error(path, "cannot flush to disk", errno);
}

fs::path folder_of(const fs::path& path) {
  const fs::path folder = path.parent_path();
  return folder.empty() ? fs::path(".") : folder;
}

fs::path temporary_beside(const fs::path& path) {
  return folder_of(path) /
         ("." + path.stem().string() + "." + std::to_string(::getpid()) + ".tmp" + path.extension().string());
}

void refuse_existing(const fs::path& path, bool overwrite) {
  std::error_code code;
  if (!overwrite && fs::exists(path, code))
    throw Error(ErrorCode::already_exists, "output exists")
        .file(path.string())
        .hint("Choose another name or add --overwrite");
}

void rename_checked(const fs::path& from, const fs::path& to) {
  if (::rename(from.c_str(), to.c_str()) != 0) throw io_error(to, "cannot put the file in place", errno);
}

}  // namespace

StagedFile::StagedFile(fs::path final_path, bool overwrite)
    : final_(std::move(final_path)), temporary_(temporary_beside(final_)) {
  refuse_existing(final_, overwrite);
  const fs::path folder = folder_of(final_);
  std::error_code code;
  if (!fs::is_directory(folder, code)) {
    fs::create_directories(folder, code);
    if (code) throw io_error(folder, "cannot create the folder", code.value());
  }
  if (::access(folder.c_str(), W_OK) != 0) throw io_error(folder, "cannot write in the folder", errno);
}

StagedFile::~StagedFile() {
  if (committed_) return;
  std::error_code ignored;
  fs::remove(temporary_, ignored);
}

void StagedFile::commit() {
  sync_path(temporary_, O_RDONLY);
  rename_checked(temporary_, final_);
  committed_ = true;
  sync_path(folder_of(final_), O_RDONLY | O_DIRECTORY);
}

StagedFolder::StagedFolder(fs::path final_path, bool overwrite) : final_(std::move(final_path)), overwrite_(overwrite) {
  if (final_.filename().empty()) final_ = final_.parent_path();
  temporary_ = temporary_beside(final_);
  std::error_code code;
  if (fs::is_directory(final_, code) && fs::is_empty(final_, code)) overwrite_ = true;
  refuse_existing(final_, overwrite_);
  fs::remove_all(temporary_, code);
  fs::create_directories(temporary_, code);
  if (code) throw io_error(temporary_, "cannot create the folder", code.value());
}

StagedFolder::~StagedFolder() {
  if (committed_) return;
  std::error_code ignored;
  fs::remove_all(temporary_, ignored);
}

void StagedFolder::commit() {
  sync_tree(temporary_);
  std::error_code code;
  if (overwrite_ && fs::exists(final_, code)) {
    // A folder cannot be replaced in one step: the old one moves aside first, so a crash
    // leaves either the old or the new one under a name that can be found.
    fs::path old = temporary_;
    old += ".old";
    rename_checked(final_, old);
    rename_checked(temporary_, final_);
    fs::remove_all(old, code);
  } else {
    rename_checked(temporary_, final_);
  }
  committed_ = true;
  sync_path(folder_of(final_), O_RDONLY | O_DIRECTORY);
}

void write_file(const fs::path& path, std::string_view content) {
  Descriptor file(::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666));
  if (file.get() < 0) throw io_error(path, "cannot create the file", errno);
  std::size_t written = 0;
  while (written < content.size()) {
    const ssize_t n = ::write(file.get(), content.data() + written, content.size() - written);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0)
      throw io_error(
          path, "write failed after " + std::to_string(written) + " of " + std::to_string(content.size()) + " bytes",
          n < 0 ? errno : ENOSPC);
    written += static_cast<std::size_t>(n);
  }
  if (::close(file.release()) != 0) throw io_error(path, "cannot finish the file", errno);
}

void write_file_atomic(const fs::path& path, std::string_view content, bool overwrite) {
  StagedFile staged(path, overwrite);
  write_file(staged.path(), content);
  staged.commit();
}

std::string read_file(const fs::path& path, std::uintmax_t max_bytes) {
  Descriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (file.get() < 0)
    throw Error(ErrorCode::not_found, std::string("cannot read the file: ") + std::strerror(errno))
        .file(path.string())
        .hint("Check the path");
  std::error_code code;
  const std::uintmax_t size = fs::file_size(path, code);
  if (!code && size > max_bytes)
    throw Error(ErrorCode::invalid_input, "file too large")
        .file(path.string())
        .found(std::to_string(size) + " bytes")
        .allowed("at most " + std::to_string(max_bytes));
  std::string content;
  if (!code) content.reserve(size);
  char buffer[1 << 16];
  while (true) {
    const ssize_t n = ::read(file.get(), buffer, sizeof buffer);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0)
      throw Error(ErrorCode::invalid_input, std::string("cannot read the file: ") + std::strerror(errno))
          .file(path.string());
    if (n == 0) break;
    content.append(buffer, static_cast<std::size_t>(n));
    if (content.size() > max_bytes)
      throw Error(ErrorCode::invalid_input, "file too large")
          .file(path.string())
          .allowed("at most " + std::to_string(max_bytes) + " bytes");
  }
  return content;
}

void sync_tree(const fs::path& folder) {
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.is_directory()) sync_path(entry.path(), O_RDONLY | O_DIRECTORY);
    else if (entry.is_regular_file()) sync_path(entry.path(), O_RDONLY);
  }
  sync_path(folder, O_RDONLY | O_DIRECTORY);
}

}  // namespace cairn::base
