/// When a loop over nodes is worth more than one thread.
#pragma once

#include <cstdint>

namespace veriflex::fluid {

/// Fewer nodes than these are not: at 16^3 two threads take 1.4 times as long for a step as one, at 24^3 0.8
/// times.
constexpr std::int64_t worth_threads = 8192;

}  // namespace veriflex::fluid
