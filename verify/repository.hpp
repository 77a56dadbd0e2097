/// Where the repository keeps what the commands read.
#pragma once

#include <filesystem>

namespace veriflex::repository {

inline const std::filesystem::path cases = VERIFLEX_SOURCE_DIR "/cases";
inline const std::filesystem::path references = VERIFLEX_SOURCE_DIR "/reference";

}  // namespace veriflex::repository
