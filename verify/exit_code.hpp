/// The exit codes of the `veriflex` command.
#pragma once

#include <array>
#include <string>

namespace veriflex::exit_code {

inline constexpr int success = 0;
inline constexpr int check_failed = 1;  // a verdict is `fail`
inline constexpr int input = 2;         // a case, reference or option cannot be used
inline constexpr int numerical =
    3;                             // a run left its validity, its memory, or was interrupted: verdict `error`
inline constexpr int output = 4;   // something could not be written, or a child process died
inline constexpr int skipped = 5;  // of run: a case needs what this program was built without

/// Of a case without an answer, by the kind of its error.
inline int of_error(const std::string& kind) {
  if (kind == "input") return input;
  if (kind == "lacking") return skipped;
  return kind == "output" ? output : numerical;
}

/// Whether nothing went wrong.
inline bool is_well(int code) { return code == success || code == skipped; }

/// The graver of two: the first of 4, 2, 3, 1, 5 among them.
inline int first_of(int a, int b) {
  for (const int code : std::array{output, input, numerical, check_failed, skipped}) {
    if (a == code || b == code) return code;
  }
  return success;
}

}  // namespace veriflex::exit_code
