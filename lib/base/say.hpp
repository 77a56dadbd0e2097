/// Words to the user that never throw: what is said must not decide what becomes of a run.
#pragma once

#include <fmt/format.h>

#include <cstdio>

namespace veriflex {

/// Formats to a stream; what could not be written is remembered by the stream alone (std::ferror).
template <class... Values>
void say_to(std::FILE* stream, fmt::format_string<Values...> format, Values&&... values) noexcept {
  try {
    const std::string text = fmt::format(format, std::forward<Values>(values)...);
    std::fwrite(text.data(), 1, text.size(), stream);
  } catch (...) {
    std::fputs("veriflex: a message could not be made\n", stderr);
  }
}

/// To standard output.
template <class... Values>
void say(fmt::format_string<Values...> format, Values&&... values) noexcept {
  say_to(stdout, format, std::forward<Values>(values)...);
}

/// To standard error, after `veriflex: `.
template <class... Values>
void complain(fmt::format_string<Values...> format, Values&&... values) noexcept {
  std::fputs("veriflex: ", stderr);
  say_to(stderr, format, std::forward<Values>(values)...);
  std::fputs("\n", stderr);
}

}  // namespace veriflex
