#include "base/memory.hpp"

#include <malloc.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <new>
#include <string>

namespace veriflex {

namespace {
std::atomic<std::size_t> mapped{0};  // by allocate_pages()

double of_the_machine() {
  std::ifstream info("/proc/meminfo");
  std::string name;
  for (double kilobytes = 0.0; info >> name >> kilobytes; std::getline(info, name)) {
    if (name == "MemAvailable:") return kilobytes * 1024.0;
  }
  return static_cast<double>(sysconf(_SC_AVPHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGESIZE));
}

// What `ulimit -v` leaves.
double of_the_process() {
  struct rlimit limit {};
  if (getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return INFINITY;
  double pages = 0.0;
  std::ifstream("/proc/self/statm") >> pages;
  return static_cast<double>(limit.rlim_cur) - pages * static_cast<double>(sysconf(_SC_PAGESIZE));
}

// The limit of the control group that a batch system or a container has put us into, and of those around it.
// What is used of it is not taken off: much of that are files' pages that the system gives up when asked.
double of_the_group() {
  std::ifstream groups("/proc/self/cgroup");
  double least = INFINITY;
  for (std::string line; std::getline(groups, line);) {
    if (!line.starts_with("0::/")) continue;
    for (std::filesystem::path group = line.substr(4);; group = group.parent_path()) {
      double limit = 0.0;  // without one the file says "max"
      if (std::ifstream("/sys/fs/cgroup" / group / "memory.max") >> limit) least = std::min(least, limit);
      if (group.empty()) break;
    }
  }
  return least;
}

}  // namespace

double available_memory_bytes() {
  return std::max(0.0, std::min({of_the_machine(), of_the_process(), of_the_group()}));
}

double allocated_bytes() {
  const struct mallinfo2 ordinary = mallinfo2();
  return static_cast<double>(ordinary.uordblks + ordinary.hblkhd) + static_cast<double>(mapped);
}

void Unmap::operator()(std::byte* memory) const {
  munmap(memory, bytes);
  mapped -= bytes;
}

Pages allocate_pages(std::size_t bytes) {
  void* const memory = mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (memory == MAP_FAILED) throw std::bad_alloc();
  mapped += bytes;
  madvise(memory, bytes, MADV_HUGEPAGE);  // only a wish: ordinary pages cost 5 %
  return Pages(static_cast<std::byte*>(memory), Unmap{bytes});
}

}  // namespace veriflex
