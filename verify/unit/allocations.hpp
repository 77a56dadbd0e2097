// What a piece of code allocates, without any trace of it in the code: the linker leads the calls of malloc
// (Eigen) and operator new (the rest) of this binary through a counter.
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

// Sizes in bytes, in order, of all that `work` allocates in this thread.
std::vector<std::size_t> allocations_of(const std::function<void()>& work);
