/// Names of earlier versions of the case file's schema, and what became of them.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "io/document.hpp"

namespace veriflex::engine {

/// The version of cases/README.md that this program reads.
inline constexpr std::int64_t case_schema = 2;

/// The present name of a key that was renamed, by its dotted path in a case; entries of `[[name]]` are
/// `name[]`. Nothing for a path that is no old one.
std::optional<std::string> present_name(std::string_view path);

/// The same of an option of `derive` and `calibrate`: `--depth`, or `--depth=1`, is `--epsilon` now.
std::optional<std::string> present_option(std::string_view word);

/// Holds the case against the present schema: one error for another version, which lists what the case has to
/// rename, or one for each old key, at its place. Empty when there is nothing to rename.
std::vector<InputError> old_names(const io::Table& top);

}  // namespace veriflex::engine
