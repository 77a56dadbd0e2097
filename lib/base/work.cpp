#include "base/work.hpp"

#include <mutex>

namespace veriflex::work {

namespace {

std::mutex guard;
Tally* first = nullptr;
Counts gone;  // of threads that have ended

void add_to(Counts& sum, const Tally& tally) {
  for (const Field& field : fields) {
    sum.*field.count += (tally.*field.tally).load(std::memory_order_relaxed);
  }
}

}  // namespace

Tally::Tally() {
  const std::lock_guard lock(guard);
  next = first;
  if (next != nullptr) next->previous = this;
  first = this;
}

Tally::~Tally() {
  const std::lock_guard lock(guard);
  add_to(gone, *this);
  if (next != nullptr) next->previous = previous;
  (previous != nullptr ? previous->next : first) = next;
}

Counts done() {
  const std::lock_guard lock(guard);
  Counts sum = gone;
  for (const Tally* tally = first; tally != nullptr; tally = tally->next) add_to(sum, *tally);
  return sum;
}

}  // namespace veriflex::work
