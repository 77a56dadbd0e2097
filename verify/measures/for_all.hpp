/// Independent pieces of a study on all threads.
#pragma once

#include <exception>
#include <string>
#include <vector>

#include "base/progress.hpp"
#include "base/stop.hpp"

namespace veriflex::measures {

/// Calls work(i) for every i < count. The pieces must not depend on each other, so that results do not depend
/// on the number of threads. keep(i) is called for each piece that came to its end, never by two threads at
/// once and in the order of i, as soon as the pieces before it have ended: what it stores stays, whatever
/// happens to other pieces. The exception of the lowest i is rethrown, as it would be without threads.
template <class Work, class Keep>
void for_all(std::size_t count, const std::string& phase, Progress& progress, Work work, Keep keep) {
  std::vector<std::exception_ptr> errors(count);
  std::vector<char> ended(count, 0);
  std::size_t done = 0, kept = 0;
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
      ended[i] = 1;
      for (; kept < count && ended[kept] != 0; ++kept) {
        try {
          if (!errors[kept]) keep(kept);
        } catch (...) {
          errors[kept] = std::current_exception();
        }
      }
      try {
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

}  // namespace veriflex::measures
