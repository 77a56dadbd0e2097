/// How many threads the machine gives, and the team of them.
#pragma once

namespace veriflex {

/// The threads to compute with: those asked for (0: one per core), or as many as can be had, with a word
/// about it. OpenMP would end the program when it cannot have a thread.
int usable_threads(int asked);

/// Has OpenMP make a team of so many threads, for all that follows. Where it lacks the memory for that it
/// ends the program, in words that say nothing of a remedy: they are kept back, see gives_up_team().
void make_team(int threads);

/// At the end of the program: whether make_team() is what ended it. Standard error is open again after this.
bool gives_up_team();

}  // namespace veriflex
