#include "threads.hpp"

#include <omp.h>

#include <algorithm>
#include <latch>
#include <system_error>
#include <thread>
#include <vector>

#include "base/say.hpp"

namespace veriflex {

namespace {

// Of `wanted` threads, this one included, as many as exist at the same time.
int threads_to_be_had(int wanted) {
  std::latch all_made(1);
  std::vector<std::thread> made;
  made.reserve(static_cast<std::size_t>(wanted));
  try {
    while (static_cast<int>(made.size()) + 1 < wanted) made.emplace_back([&] { all_made.wait(); });
  } catch (const std::system_error&) {
  }
  all_made.count_down();
  for (std::thread& thread : made) thread.join();
  return static_cast<int>(made.size()) + 1;
}

}  // namespace

int usable_threads(int asked) {
  constexpr int max_threads = 4096;
  const int wanted = std::min(asked > 0 ? asked : omp_get_max_threads(), max_threads);
  const int had = threads_to_be_had(wanted);
  if (had == wanted) return had;
  const int used = (had + 1) / 2;  // the run needs some of what the others would take
  complain("{} threads instead of {}: the system gives no more. Results are the same", used, wanted);
  return used;
}

}  // namespace veriflex
