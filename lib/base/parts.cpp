#include "base/parts.hpp"

#include <algorithm>
#include <map>
#include <mutex>
#include <utility>

#include "base/memory.hpp"
#include "base/mutant.hpp"

namespace veriflex::parts {

namespace {

struct Shared {
  int holders = 0;
  double bytes = 0.0;
};

struct Registry {
  std::mutex guard;
  AllMade made;
  std::array<double, kinds.size()> bytes{};  // of those that exist
  std::array<std::uint64_t, kinds.size()> existing{};
  std::map<std::pair<Kind, const void*>, Shared> shared;
  double total = 0.0, allocated_at_restart = 0.0;
  Peak peak;

  void change(Kind kind, double by) {
    const auto k = static_cast<std::size_t>(kind);
    bytes[k] += by;
    total += by;
    made[k].bytes = std::max(made[k].bytes, bytes[k]);
    if (total > peak.bytes) peak = {total, allocated_bytes() - allocated_at_restart};
  }
};

// Never destroyed: parts of static objects may outlive it.
Registry& registry() {
  static Registry& one = *new Registry;
  return one;
}

}  // namespace

Built::Built(Kind kind, double bytes, const void* shared)
    : kind_(kind),
      bytes_((planted(Mutant::parts_bytes_short) ? 0.9 : 1.0) * bytes),
      shared_(shared),
      exists_(true) {
  Registry& all = registry();
  const std::lock_guard lock(all.guard);
  ++all.made[static_cast<std::size_t>(kind)].count;
  ++all.existing[static_cast<std::size_t>(kind)];
  if (shared != nullptr) {
    Shared& one = all.shared[{kind, shared}];
    if (one.holders++ > 0) return;
    one.bytes = bytes;
  }
  all.change(kind, bytes);
}

Built::Built(const Built& other) : Built() {
  if (other.exists_) *this = Built(other.kind_, other.bytes_, other.shared_);
}

Built::Built(Built&& other) noexcept
    : kind_(other.kind_),
      bytes_(other.bytes_),
      shared_(other.shared_),
      exists_(std::exchange(other.exists_, false)) {}

Built& Built::operator=(Built other) noexcept {
  std::swap(kind_, other.kind_);
  std::swap(bytes_, other.bytes_);
  std::swap(shared_, other.shared_);
  std::swap(exists_, other.exists_);
  return *this;
}

Built::~Built() {
  if (!exists_) return;
  Registry& all = registry();
  const std::lock_guard lock(all.guard);
  --all.existing[static_cast<std::size_t>(kind_)];
  double gone = bytes_;
  if (shared_ != nullptr) {
    const auto one = all.shared.find({kind_, shared_});
    if (--one->second.holders > 0) return;
    gone = one->second.bytes;
    all.shared.erase(one);
  }
  all.change(kind_, -gone);
}

void Built::takes(double bytes) {
  if (bytes == bytes_) return;
  Registry& all = registry();
  const std::lock_guard lock(all.guard);
  all.change(kind_, bytes - bytes_);
  bytes_ = bytes;
}

AllMade made() {
  Registry& all = registry();
  const std::lock_guard lock(all.guard);
  return all.made;
}

Peak peak() {
  Registry& all = registry();
  const std::lock_guard lock(all.guard);
  return all.peak;
}

Aside::~Aside() {
  Registry& all = registry();
  const std::lock_guard lock(all.guard);
  all.made = made_;
}

void restart() {
  Registry& all = registry();
  const std::lock_guard lock(all.guard);
  for (std::size_t k = 0; k < kinds.size(); ++k) all.made[k] = {all.existing[k], all.bytes[k]};
  all.allocated_at_restart = allocated_bytes() - all.total;
  all.peak = {all.total, all.total};
}

}  // namespace veriflex::parts
