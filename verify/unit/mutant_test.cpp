// Planted bugs: none is left in a normal build, and in one for them each can be chosen.
#include "base/mutant.hpp"

#include <set>

#include "catch.hpp"
#include "repository.hpp"
#include "unit/command.hpp"

using namespace veriflex;
using unit::Folder;

namespace {

std::string sources_of(const std::string& folder) {
  std::string all;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(repository::root() / folder)) {
    const std::string extension = entry.path().extension();
    if (extension == ".hpp" || extension == ".cpp") all += unit::contents(entry.path());
  }
  return all;
}

const std::string derive = "\"$V\" derive --epsilon 2 --sigma 3";

/// What the derived numbers of a law are with that bug.
unit::Ran derived_with(const std::string& mutant) {
  const Folder folder;
  return folder.shell("export VERIFLEX_MUTANT='" + mutant + "'; " + derive);
}

}  // namespace

TEST_CASE("Names of planted bugs are unique, each says what is wrong and is planted somewhere") {
  const std::string sources = sources_of("lib") + sources_of("verify");
  std::set<std::string_view> names, texts;
  for (const Named<Mutant>& mutant : mutants) {
    CAPTURE(mutant.name);
    CHECK(names.insert(mutant.name).second);
    CHECK(texts.insert(mutant.text).second);
    CHECK(mutant.text.size() > 10);
    CHECK(sources.find("planted(Mutant::" + std::string(mutant.name) + ")") != std::string::npos);
  }
}

#ifndef VERIFLEX_MUTANTS

namespace {
// Known to the compiler, so that it leaves nothing of a switch in the program.
constexpr bool any_is_planted() {
  for (const Named<Mutant>& mutant : mutants) {
    if (planted(mutant.value)) return true;
  }
  return planted(Mutant::none);
}
static_assert(!any_is_planted());
}  // namespace

TEST_CASE("A normal build has no planted bug, whatever the environment asks for") {
  const unit::Ran without = derived_with("");
  REQUIRE(without.code == 0);
  for (const std::string mutant : {"young_modulus_without_spacing", "there_is_no_such_bug"}) {
    const unit::Ran with = derived_with(mutant);
    CHECK(with.code == 0);
    CHECK(with.out == without.out);
  }
}

#else

TEST_CASE("A planted bug is there when its name is given, and an unknown name is refused") {
  const unit::Ran without = derived_with("none");
  CHECK(without.code == 2);
  CHECK_THAT(without.err, ContainsSubstring("no bug 'none' is planted"));
  const unit::Ran near = derived_with("young_modulus_without_spacin");
  CHECK(near.code == 2);
  CHECK_THAT(near.err, ContainsSubstring("Did you mean 'young_modulus_without_spacing'?"));
  const Folder folder;
  const unit::Ran good = folder.shell("unset VERIFLEX_MUTANT; " + derive);
  const unit::Ran bad = derived_with("young_modulus_without_spacing");
  CHECK(good.code == 0);
  CHECK(bad.code == 0);
  CHECK(good.out != bad.out);
}

#endif
