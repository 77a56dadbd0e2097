/// Subnormal numbers taken as zero.
#pragma once

#if defined(__SSE2__)
#include <xmmintrin.h>
#endif

namespace veriflex::fluid {

/// Fluid at rest is full of subnormal numbers, each of which costs a hundred cycles: flushed to zero in this
/// thread while this lives.
class FlushSubnormals {
 public:
#if defined(__SSE2__)
  FlushSubnormals() : before_(_mm_getcsr()) { _mm_setcsr(before_ | 0x8040U); }
  ~FlushSubnormals() { _mm_setcsr(before_); }
#else
  FlushSubnormals() {}
#endif
  FlushSubnormals(const FlushSubnormals&) = delete;
  FlushSubnormals& operator=(const FlushSubnormals&) = delete;

 private:
#if defined(__SSE2__)
  unsigned before_;
#endif
};

}  // namespace veriflex::fluid
