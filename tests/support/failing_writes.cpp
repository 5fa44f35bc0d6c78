// LD_PRELOAD shim: the n-th write to a regular file of the process fails as on a full disk, and all
// later ones too. n comes from CAIRN_FAIL_WRITE; CAIRN_FAIL_LOG names a file that receives one line
// when the failure struck.
#include <dlfcn.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <sys/uio.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstdlib>

namespace {

std::atomic<long> writes{0};

template <typename Function>
Function* next(const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
}

bool fails(int fd) {
  static const char* limit_text = std::getenv("CAIRN_FAIL_WRITE");
  if (limit_text == nullptr) return false;
  static const long limit = std::atol(limit_text);
  struct stat info {};
  if (fstat(fd, &info) != 0 || !S_ISREG(info.st_mode) || fd <= 2) return false;
  const long number = ++writes;
  if (number < limit) return false;
  if (number == limit) {
    if (const char* log = std::getenv("CAIRN_FAIL_LOG")) {
      const int out = open(log, O_WRONLY | O_CREAT | O_APPEND, 0600);
      auto* real = next<ssize_t(int, const void*, size_t)>("write");
      if (out >= 0) {
        real(out, "struck\n", 7);
        close(out);
      }
    }
  }
  errno = ENOSPC;
  return true;
}

}  // namespace

extern "C" {

ssize_t write(int fd, const void* data, size_t size) {
  static auto* real = next<ssize_t(int, const void*, size_t)>("write");
  return fails(fd) ? -1 : real(fd, data, size);
}

ssize_t pwrite64(int fd, const void* data, size_t size, off64_t offset) {
  static auto* real = next<ssize_t(int, const void*, size_t, off64_t)>("pwrite64");
  return fails(fd) ? -1 : real(fd, data, size, offset);
}

ssize_t pwrite(int fd, const void* data, size_t size, off_t offset) {
  static auto* real = next<ssize_t(int, const void*, size_t, off_t)>("pwrite");
  return fails(fd) ? -1 : real(fd, data, size, offset);
}

ssize_t writev(int fd, const struct iovec* parts, int count) {
  static auto* real = next<ssize_t(int, const struct iovec*, int)>("writev");
  return fails(fd) ? -1 : real(fd, parts, count);
}

size_t fwrite(const void* data, size_t size, size_t count, FILE* stream) {
  static auto* real = next<size_t(const void*, size_t, size_t, FILE*)>("fwrite");
  return stream != stdout && stream != stderr && fails(fileno(stream)) ? 0 : real(data, size, count, stream);
}
}
