#include "io/file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <openssl/evp.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <new>

#include "base/error.hpp"

namespace veriflex::io {

namespace fs = std::filesystem;

namespace {

[[noreturn]] void cannot_read(const fs::path& path) {
  if (errno == ENOMEM) throw std::bad_alloc();  // a stream takes that for a file that cannot be read
  throw InputError({path.string()}, "cannot be read", std::strerror(errno),
                   "Look at the path and its permissions");
}

std::ifstream opened(const fs::path& path) {
  std::error_code error;
  if (fs::is_directory(path, error)) {
    throw InputError({path.string()}, "is a folder", "a file is needed", "Name the file itself");
  }
  if (fs::exists(path, error) && !fs::is_regular_file(path, error)) {
    throw InputError({path.string()}, "is a device or pipe", "a file is needed", "Name a file");
  }
  std::ifstream in(path, std::ios::binary);
  if (!in) cannot_read(path);
  return in;
}

}  // namespace

std::string read_file(const fs::path& path) {
  std::ifstream in = opened(path);
  // In one piece, and a byte more than there should be, to meet the end; a file may also have no size, or
  // grow.
  std::error_code unknown;
  const std::uintmax_t size = fs::file_size(path, unknown);
  std::size_t more = unknown ? 4096 : static_cast<std::size_t>(size) + 1;
  std::string bytes;
  while (in) {
    const std::size_t at = bytes.size();
    bytes.resize(at + more);
    in.read(bytes.data() + at, static_cast<std::streamsize>(more));
    bytes.resize(at + static_cast<std::size_t>(in.gcount()));
    more = 65536;
  }
  if (in.bad()) cannot_read(path);
  return bytes;
}

std::string read_start(const fs::path& path, std::size_t count) {
  std::ifstream in = opened(path);
  std::string bytes(count, '\0');
  in.read(bytes.data(), static_cast<std::streamsize>(count));
  if (in.bad()) cannot_read(path);
  bytes.resize(static_cast<std::size_t>(in.gcount()));
  return bytes;
}

std::string sha256(std::string_view bytes) {
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  unsigned size = 0;
  if (EVP_Digest(bytes.data(), bytes.size(), digest.data(), &size, EVP_sha256(), nullptr) != 1) {
    throw std::runtime_error("SHA-256 is not available from the OpenSSL library");
  }
  std::string hex;
  for (unsigned i = 0; i < size; ++i) hex += fmt::format("{:02x}", digest[i]);
  return hex;
}

namespace {

// A file that is being written carries a lock, so that one without was left by a writer that is gone.
const std::string aside_start = ".veriflex-";
const std::string aside_end = ".part";

void sweep(const fs::path& folder) {
  std::error_code error;
  for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error)) {
    const std::string name = at->path().filename().string();
    if (!name.starts_with(aside_start) || !name.ends_with(aside_end)) continue;
    const int file = open(at->path().c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
    if (file < 0) continue;
    if (flock(file, LOCK_EX | LOCK_NB) == 0) unlink(at->path().c_str());
    close(file);
  }
}

struct Aside {
  std::string path;
  int file;  // negative: errno says why there is none
};

Aside new_file_in(const fs::path& folder) {
  static std::atomic<unsigned> count = 0;
  for (;;) {
    Aside made{(folder / fmt::format("{}{}-{}{}", aside_start, getpid(), count++, aside_end)).string(), -1};
    made.file = open(made.path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (made.file < 0 && errno == EEXIST) continue;
    if (made.file < 0) return made;
    flock(made.file, LOCK_EX);
    struct stat state {};
    if (fstat(made.file, &state) != 0 || state.st_nlink > 0) return made;
    close(made.file);  // swept away before it was locked
  }
}

// 0, or why not all bytes reached the disk.
int write_all(int file, std::span<const char> bytes) {
  for (std::size_t done = 0; done < bytes.size();) {
    const ssize_t wrote = write(file, bytes.data() + done, bytes.size() - done);
    if (wrote < 0 && errno != EINTR) return errno;
    if (wrote > 0) done += static_cast<std::size_t>(wrote);
  }
  return fsync(file) != 0 && errno != EINVAL ? errno : 0;
}

}  // namespace

void write_file(const fs::path& path, std::span<const char> bytes) {
  const std::string remedy = "Choose another place with --out, or make room and permissions there";
  const auto fail = [&](int error) {
    throw OutputError(path.string(), fmt::format("cannot be written ({})", std::strerror(error)), remedy);
  };
  const fs::path folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) fail(error.value());
  struct stat there {};
  if (lstat(path.c_str(), &there) == 0 && !S_ISREG(there.st_mode) && !S_ISDIR(there.st_mode)) {
    throw OutputError(path.string(), "cannot be written (a link, device or pipe stands there)",
                      "Remove it, or choose another place");
  }
  sweep(folder);
  const Aside aside = new_file_in(folder);
  if (aside.file < 0) fail(errno);
  int failed = write_all(aside.file, bytes);
  if (failed == 0 && rename(aside.path.c_str(), path.c_str()) != 0) failed = errno;
  if (failed != 0) unlink(aside.path.c_str());
  if (close(aside.file) != 0 && failed == 0) failed = errno;
  if (failed != 0) fail(failed);
}

}  // namespace veriflex::io
