// So many threads until the end of a scope. More than one would wait for each other most of the time in the
// small boxes of these tests.
#pragma once

#include <omp.h>

namespace veriflex::unit {

class Threads {
 public:
  explicit Threads(int count) { omp_set_num_threads(count); }
  ~Threads() { omp_set_num_threads(before_); }
  Threads(const Threads&) = delete;
  Threads& operator=(const Threads&) = delete;

 private:
  int before_ = omp_get_max_threads();
};

}  // namespace veriflex::unit
