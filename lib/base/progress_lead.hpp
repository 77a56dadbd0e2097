/// Words before every progress line, for a program that does one long work after another.
#pragma once

#include <string>

namespace veriflex {

/// Every Progress line begins with these words from now on.
void lead_progress_with(const std::string& words);

}  // namespace veriflex
