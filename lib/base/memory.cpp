#include "base/memory.hpp"

#include <malloc.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <bit>
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

// As the kernel lists them, one directory each. What the C library says of a cache that several processors
// share is ten times its size on some machines.
Cache largest_listed() {
  Cache largest{1 << 20, 1};
  for (int i = 0;; ++i) {
    const std::filesystem::path cache = "/sys/devices/system/cpu/cpu0/cache/index" + std::to_string(i);
    std::int64_t kilobytes = 0;
    std::string shared_by;  // a bit each, in hexadecimal with commas
    if (!(std::ifstream(cache / "size") >> kilobytes)) return largest;  // followed by a K
    if (!(std::ifstream(cache / "shared_cpu_map") >> shared_by)) return largest;
    int processors = 0;
    for (const char digit : shared_by) {
      if (digit != ',') processors += std::popcount(std::stoul(std::string(1, digit), nullptr, 16));
    }
    if (kilobytes * 1024 > largest.bytes) largest = {kilobytes * 1024, std::max(1, processors)};
  }
}

}  // namespace

Cache largest_cache() {
  static const Cache largest = largest_listed();
  return largest;
}

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
