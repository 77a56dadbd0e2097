/// Files that a run leaves beside its result.
#pragma once

#include <filesystem>

#include "observe/attach.hpp"

namespace veriflex::engine {

/// `<folder>/<name>.snapshots`, for the result of that name.
std::filesystem::path attachments_folder(const std::string& name, const std::filesystem::path& folder);

/// What becomes of the files that an earlier run has left.
enum class EarlierFiles { go, stay };

/// Writes files into `folder`, each aside and renamed; what an earlier run has left of their kinds (.vtu,
/// .vti, .pvd, .hdf, .series, .data) is removed at once, unless the run goes on from there. What it writes
/// throws OutputError where it cannot.
observe::Attach attach_to(const std::filesystem::path& folder, EarlierFiles of_earlier = EarlierFiles::go);

}  // namespace veriflex::engine
