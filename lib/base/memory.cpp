#include "base/memory.hpp"

#include <malloc.h>
#include <sys/mman.h>
#include <unistd.h>

#include <atomic>
#include <fstream>
#include <new>
#include <string>

namespace veriflex {

namespace {
std::atomic<std::size_t> mapped{0};  // by allocate_pages()
}

double available_memory_bytes() {
  std::ifstream info("/proc/meminfo");
  std::string name;
  for (double kilobytes = 0.0; info >> name >> kilobytes; std::getline(info, name)) {
    if (name == "MemAvailable:") return kilobytes * 1024.0;
  }
  return static_cast<double>(sysconf(_SC_AVPHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGESIZE));
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
