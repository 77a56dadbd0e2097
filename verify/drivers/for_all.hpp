/// Independent pieces of a study on all threads.
#pragma once

#include <exception>
#include <string>
#include <vector>

#include "base/progress.hpp"

namespace veriflex::drivers {

/// Calls work(i) for every i < count. The pieces must not depend on each other, so that results do not depend
/// on the number of threads. The exception of the lowest i is rethrown, as it would be without threads.
template <class Work>
void for_all(std::size_t count, const std::string& phase, Progress& progress, Work work) {
  std::vector<std::exception_ptr> errors(count);
  std::size_t done = 0;
#pragma omp parallel for schedule(dynamic)
  for (std::size_t i = 0; i < count; ++i) {
    try {
      work(i);
    } catch (...) {
      errors[i] = std::current_exception();
    }
#pragma omp critical
    progress.show(phase, ++done, count);
  }
  for (const std::exception_ptr& error : errors) {
    if (error) std::rethrow_exception(error);
  }
}

}  // namespace veriflex::drivers
