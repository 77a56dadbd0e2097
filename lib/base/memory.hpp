/// Memory of the machine, and large arrays in it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>

namespace veriflex {

/// What the system can still give without swapping, within the limits set on this process and on its control
/// group  [bytes].
double available_memory_bytes();

/// The largest cache beside a processor, and how many processors share it.
struct Cache {
  std::int64_t bytes;
  int processors;
};

/// Of the first processor; where the system does not say, 1 MB of one processor.
Cache largest_cache();

/// What the allocators of this program have given out: of ordinary memory, and by allocate_pages(). 0 of the
/// former where another allocator stands in for the system's  [bytes].
double allocated_bytes();

struct Unmap {
  std::size_t bytes = 0;
  void operator()(std::byte* memory) const;
};

/// Zeroed memory in huge pages where the system has them, at a page's start; pages are placed by the thread
/// that first writes to them. Throws std::bad_alloc.
using Pages = std::unique_ptr<std::byte[], Unmap>;
Pages allocate_pages(std::size_t bytes);

}  // namespace veriflex
