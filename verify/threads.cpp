#include "threads.hpp"

#include <fcntl.h>
#include <omp.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <iterator>
#include <latch>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include "base/say.hpp"

namespace veriflex {

namespace {

// A joined thread counts against the system's limit until the kernel has put it away, which may be later:
// a team made in between would lack it. Waits for that, at most a second.
void await_their_end() {
  namespace fs = std::filesystem;
  for (int ms = 0; ms < 1000; ++ms) {
    std::error_code none;
    const fs::directory_iterator alive("/proc/self/task", none);
    if (none || std::distance(begin(alive), end(alive)) <= 1) return;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
}

// Of `wanted` threads, this one included, as many as exist at the same time, each with memory of its own:
// the allocator sets some aside for a thread that asks.
int threads_to_be_had(int wanted) {
  std::latch all_made(1);
  std::vector<std::thread> made;
  made.reserve(static_cast<std::size_t>(wanted));
  try {
    while (static_cast<int>(made.size()) + 1 < wanted) {
      made.emplace_back([&] {
        void* volatile memory = std::malloc(1024);  // volatile: else the compiler leaves it out
        all_made.wait();
        std::free(memory);
      });
    }
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
  await_their_end();
  const int used = (had + 1) / 2;  // the run needs some of what the others would take
  complain("{} threads instead of {}: the system gives no more. Results are the same", used, wanted);
  return used;
}

namespace {
int standard_error = -1;  // where it leads, while a team is made and it leads nowhere
}

void make_team(int threads) {
  standard_error = fcntl(STDERR_FILENO, F_DUPFD_CLOEXEC, 0);
  const int nowhere = open("/dev/null", O_RDONLY | O_CLOEXEC);
  if (standard_error >= 0) dup2(nowhere, STDERR_FILENO);
  omp_set_num_threads(threads);
  std::atomic<int> made = 0;
#pragma omp parallel
  ++made;
  gives_up_team();
  close(nowhere);
}

bool gives_up_team() {
  if (standard_error < 0) return false;
  dup2(standard_error, STDERR_FILENO);
  close(std::exchange(standard_error, -1));
  return true;
}

}  // namespace veriflex
