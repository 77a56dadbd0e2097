/// How many threads the machine gives.
#pragma once

namespace veriflex {

/// The threads to compute with: those asked for (0: one per core), or as many as can be had, with a word
/// about it. OpenMP would end the program when it cannot have a thread.
int usable_threads(int asked);

}  // namespace veriflex
