/// What is asked of OpenMP, where a compiler has none: its pragmas are passed over, and there is one thread.
#pragma once

inline int omp_get_max_threads() { return 1; }
inline int omp_get_num_threads() { return 1; }
inline int omp_get_thread_num() { return 0; }
inline void omp_set_num_threads(int) {}
