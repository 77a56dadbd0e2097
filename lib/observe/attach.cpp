#include "observe/attach.hpp"

#include <utility>

namespace veriflex::observe {

namespace {

Attach& taker() {
  static Attach to;
  return to;
}

}  // namespace

Attaching::Attaching(Attach to) { taker() = std::move(to); }

Attaching::~Attaching() { taker() = {}; }

bool is_attaching() { return static_cast<bool>(taker()); }

void attach(const std::string& name, std::string_view bytes) {
  if (is_attaching()) taker()(name, bytes);
}

}  // namespace veriflex::observe
