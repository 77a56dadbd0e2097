#include "repository.hpp"

namespace veriflex::repository {

const std::filesystem::path& cases() {
  static const std::filesystem::path folder = VERIFLEX_SOURCE_DIR "/cases";
  return folder;
}

const std::filesystem::path& references() {
  static const std::filesystem::path folder = VERIFLEX_SOURCE_DIR "/reference";
  return folder;
}

}  // namespace veriflex::repository
