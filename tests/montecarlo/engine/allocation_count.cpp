#include "tests/montecarlo/engine/allocation_count.h"

#include <cstddef>
#include <new>

// The linker puts these in the place of the functions they are named after (see tests/CMakeLists.txt).

namespace {
thread_local std::int64_t count = 0;
}

// NOLINTBEGIN(bugprone-reserved-identifier)
extern "C" {
void* __real_malloc(std::size_t size);
void* __real_calloc(std::size_t items, std::size_t size);
void* __real_realloc(void* memory, std::size_t size);
void* __real__Znwm(std::size_t size);
void* __real__Znam(std::size_t size);
void* __real__ZnwmSt11align_val_t(std::size_t size, std::align_val_t alignment);

void* __wrap_malloc(std::size_t size) {
  ++count;
  return __real_malloc(size);
}
void* __wrap_calloc(std::size_t items, std::size_t size) {
  ++count;
  return __real_calloc(items, size);
}
void* __wrap_realloc(void* memory, std::size_t size) {
  ++count;
  return __real_realloc(memory, size);
}
void* __wrap__Znwm(std::size_t size) {
  ++count;
  return __real__Znwm(size);
}
void* __wrap__Znam(std::size_t size) {
  ++count;
  return __real__Znam(size);
}
void* __wrap__ZnwmSt11align_val_t(std::size_t size, std::align_val_t alignment) {
  ++count;
  return __real__ZnwmSt11align_val_t(size, alignment);
}
}
// NOLINTEND(bugprone-reserved-identifier)

namespace credence::internal {

std::int64_t allocations_of_this_thread() { return count; }

}  // namespace credence::internal
