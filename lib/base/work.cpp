#include "base/work.hpp"

#include <mutex>

namespace veriflex::work {

namespace {

std::mutex guard;
Tally* first = nullptr;

}  // namespace

Tally* new_tally() {
  const std::lock_guard lock(guard);
  first = new Tally{.next = first};
  return first;
}

Counts done() {
  const std::lock_guard lock(guard);
  Counts sum;
  for (const Tally* tally = first; tally != nullptr; tally = tally->next) {
    for (const Field& field : fields) {
      sum.*field.count += (tally->*field.tally).load(std::memory_order_relaxed);
    }
  }
  return sum;
}

}  // namespace veriflex::work
