#include "base/mutant.hpp"

#ifdef VERIFLEX_MUTANTS

#include <cstdlib>

#include "base/error.hpp"
#include "base/say.hpp"

namespace veriflex {

namespace {

// Before main(), where nothing could be caught.
Mutant from_environment() {
  constexpr int bad_input = 2;
  const char* const name = std::getenv("VERIFLEX_MUTANT");
  if (name == nullptr) return Mutant::none;
  for (const Named<Mutant>& mutant : mutants) {
    if (mutant.name == name) return mutant.value;
  }
  const std::string near = nearest_name(name, names_of(mutants));
  complain("VERIFLEX_MUTANT: no bug '{}' is planted in this program. {}", name,
           near.empty() ? "lib/base/mutant.hpp lists all" : fmt::format("Did you mean '{}'?", near));
  std::_Exit(bad_input);
}

}  // namespace

const Mutant active_mutant = from_environment();

}  // namespace veriflex

#endif
