#include "io/file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <openssl/evp.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <sstream>

#include "base/error.hpp"

namespace veriflex::io {

namespace fs = std::filesystem;

std::string read_file(const fs::path& path) {
  std::error_code error;
  if (fs::is_directory(path, error)) {
    throw InputError({path.string()}, "is a folder", "a file is needed", "Name the file itself");
  }
  if (fs::exists(path, error) && !fs::is_regular_file(path, error)) {
    throw InputError({path.string()}, "is a device or pipe", "a file is needed", "Name a file");
  }
  std::ifstream in(path, std::ios::binary);
  std::ostringstream bytes;
  if (in) bytes << in.rdbuf();
  if (!in) {
    throw InputError({path.string()}, "cannot be read", std::strerror(errno),
                     "Look at the path and its permissions");
  }
  return bytes.str();
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

void write_file(const fs::path& path, std::span<const char> bytes) {
  const auto fail = [&](int error) {
    throw OutputError(path.string(), fmt::format("cannot be written ({})", std::strerror(error)),
                      "Choose another place with --out, or make room and permissions there");
  };
  std::error_code error;
  if (path.has_parent_path()) fs::create_directories(path.parent_path(), error);
  if (error) fail(error.value());

  const std::string aside = fmt::format("{}.part{}", path.string(), getpid());
  const int file = open(aside.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (file < 0) fail(errno);
  int failed = 0;
  for (std::size_t done = 0; failed == 0 && done < bytes.size();) {
    const ssize_t wrote = write(file, bytes.data() + done, bytes.size() - done);
    if (wrote < 0 && errno != EINTR) failed = errno;
    if (wrote > 0) done += static_cast<std::size_t>(wrote);
  }
  if (failed == 0 && fsync(file) != 0 && errno != EINVAL) failed = errno;
  if (close(file) != 0 && failed == 0) failed = errno;
  if (failed == 0 && rename(aside.c_str(), path.c_str()) != 0) failed = errno;
  if (failed != 0) {
    unlink(aside.c_str());
    fail(failed);
  }
}

}  // namespace veriflex::io
