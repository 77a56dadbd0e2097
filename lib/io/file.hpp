/// Whole files: read, checksum, and write aside then rename.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>

namespace veriflex::io {

/// The bytes of a file. Throws InputError when it cannot be read.
std::string read_file(const std::filesystem::path& path);

/// The first bytes of a file, at most `count` of them. Throws InputError when it cannot be read.
std::string read_start(const std::filesystem::path& path, std::size_t count);

/// SHA-256 in hexadecimal.
std::string sha256(std::string_view bytes);

/// Writes the bytes beside `path`, syncs, and renames: afterwards `path` holds either all of them or what it
/// held before. Makes missing folders, and removes what killed writers have left in this one. Replaces files
/// only: not a link, a device or a pipe. Throws OutputError.
void write_file(const std::filesystem::path& path, std::span<const char> bytes);

}  // namespace veriflex::io
