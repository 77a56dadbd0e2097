#include "engine/symbols.hpp"

#include <algorithm>

#include "bond/laws.hpp"

namespace veriflex::engine {

const std::vector<Symbol>& symbols() {
  static const std::vector<Symbol> all = [] {
    std::vector<Symbol> some{
        {"fluid", "tau", "relaxation_time"}, {"fluid", "nu", "viscosity"}, {"angle", "k_a", "stiffness"},
        {"solid", "r0", "spacing"},          {"body", "r0", "spacing"},
    };
    for (const bond::LawInfo& law : bond::laws()) {
      for (const bond::ParameterInfo& p : law.parameters) {
        if (p.symbol.empty()) continue;
        for (const char* table : {"bond", "compared_bond"}) some.push_back({table, p.symbol, p.name});
      }
    }
    return some;
  }();
  return all;
}

io::Table parse_case(const std::string& text, const std::string& file,
                     const std::vector<std::string>& overrides) {
  return io::parse_document(text, file, overrides, [](std::string_view table, std::string_view word) {
    const auto found = std::find_if(symbols().begin(), symbols().end(), [&](const Symbol& one) {
      return one.table == table && one.symbol == word;
    });
    return found == symbols().end() ? std::string_view() : std::string_view(found->key);
  });
}

}  // namespace veriflex::engine
