#include "threads.hpp"

#if defined(__unix__) || defined(__APPLE__)
#include <pthread.h>
#endif

namespace kinesics {

namespace {
bool forked = false;
#if defined(__unix__) || defined(__APPLE__)
const int registered = pthread_atfork(nullptr, nullptr, [] { forked = true; });
#endif
}  // namespace

bool after_fork() { return forked; }

}  // namespace kinesics
