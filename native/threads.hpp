// Threads by OpenMP where the compiler has it. After a fork the child works on one thread: GNU OpenMP's pool does not
// survive a fork, and a second parallel region there would wait for ever.
#pragma once

#include <cstdint>
#ifdef _OPENMP
#include <omp.h>
#endif

namespace kinesics {

bool after_fork();

// Calls body(i) for i in [0, count), in any order. threads: 0 as many as OpenMP gives, else that many.
template <class Body>
void parallel_for(std::int64_t count, int threads, const Body &body) {
#ifdef _OPENMP
    const int team = after_fork() ? 1 : (threads > 0 ? threads : omp_get_max_threads());
    if (team > 1 && count > 1) {
#pragma omp parallel for schedule(dynamic) num_threads(team)
        for (std::int64_t i = 0; i < count; ++i) body(i);
        return;
    }
#else
    (void)threads;
#endif
    for (std::int64_t i = 0; i < count; ++i) body(i);
}

}  // namespace kinesics
