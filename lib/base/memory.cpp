#include "base/memory.hpp"

#include <sys/mman.h>
#include <unistd.h>

#include <fstream>
#include <new>
#include <string>

namespace veriflex {

double available_memory_bytes() {
  std::ifstream info("/proc/meminfo");
  std::string name;
  for (double kilobytes = 0.0; info >> name >> kilobytes; std::getline(info, name)) {
    if (name == "MemAvailable:") return kilobytes * 1024.0;
  }
  return static_cast<double>(sysconf(_SC_AVPHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGESIZE));
}

void Unmap::operator()(std::byte* memory) const { munmap(memory, bytes); }

Pages allocate_pages(std::size_t bytes) {
  void* const memory = mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (memory == MAP_FAILED) throw std::bad_alloc();
  madvise(memory, bytes, MADV_HUGEPAGE);  // only a wish: ordinary pages cost 5 %
  return Pages(static_cast<std::byte*>(memory), Unmap{bytes});
}

}  // namespace veriflex
