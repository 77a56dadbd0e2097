/// Independent pieces of a study on all threads.
#pragma once

#include <exception>
#include <string>
#include <vector>

#include "base/progress.hpp"
#include "base/stop.hpp"

namespace veriflex::drivers {

/// Calls work(i) for every i < count. The pieces must not depend on each other, so that results do not depend
/// on the number of threads. The exception of the lowest i is rethrown, as it would be without threads.
/// keep(i) is called, never by two threads at once, for i = 0, 1, 2, ... as far as all pieces up to i are
/// done: what it stores stays when a later piece fails.
template <class Work, class Keep>
void for_all(std::size_t count, const std::string& phase, Progress& progress, Work work, Keep keep) {
  std::vector<std::exception_ptr> errors(count);
  std::vector<char> finished(count, 0);
  std::size_t done = 0;
  std::size_t kept = 0;
#pragma omp parallel for schedule(dynamic)
  for (std::size_t i = 0; i < count; ++i) {
    try {
      stop_if_asked(phase.c_str(), static_cast<std::int64_t>(i));
      work(i);
    } catch (...) {
      errors[i] = std::current_exception();
    }
#pragma omp critical
    {
      finished[i] = 1;
      try {
        for (; kept < count && finished[kept] != 0 && !errors[kept]; ++kept) keep(kept);
        progress.show(phase, ++done, count);
      } catch (...) {
        if (!errors[i]) errors[i] = std::current_exception();
      }
    }
  }
  for (const std::exception_ptr& error : errors) {
    if (error) std::rethrow_exception(error);
  }
}

/// The same with nothing to keep.
template <class Work>
void for_all(std::size_t count, const std::string& phase, Progress& progress, Work work) {
  for_all(count, phase, progress, work, [](std::size_t) {});
}

}  // namespace veriflex::drivers
