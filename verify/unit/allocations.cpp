#include "allocations.hpp"

#include <array>
#include <stdexcept>

namespace {

constexpr std::size_t most = 10000;

// Filled by the counters themselves, which must not allocate.
struct Log {
  bool open = false;
  std::size_t count = 0;
  std::array<std::size_t, most> sizes;
};
thread_local Log log_of_thread;

void count(std::size_t size) {
  Log& log = log_of_thread;
  if (log.open && log.count < most) log.sizes[log.count++] = size;
}

}  // namespace

// Names that the linker's --wrap gives: __wrap_ is called instead, __real_ is what was called before. Without
// an own declaration of the latter there is no way to it.
extern "C" {
void* __real_malloc(std::size_t size);
void* __real__Znwm(std::size_t size);
void* __wrap_malloc(std::size_t size);
void* __wrap__Znwm(std::size_t size);

void* __wrap_malloc(std::size_t size) {
  count(size);
  return __real_malloc(size);
}

void* __wrap__Znwm(std::size_t size) {
  count(size);
  return __real__Znwm(size);
}
}

std::vector<std::size_t> allocations_of(const std::function<void()>& work) {
  Log& log = log_of_thread;
  log.count = 0;
  log.open = true;
  work();
  log.open = false;
  if (log.count == most) throw std::length_error("more allocations than are counted");
  return {log.sizes.begin(), log.sizes.begin() + static_cast<std::ptrdiff_t>(log.count)};
}
