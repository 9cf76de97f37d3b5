#pragma once

namespace credence::internal {

/// Lets the heap of this process lie in large pages of 2 MB, where the system has them, and keep what is
/// freed: of a page that is touched first a virtual machine takes microseconds, and a log of 10⁵ rows touches
/// thousands of small ones. For the beginning of a program; to no effect under another malloc than that of
/// glibc.
void use_large_pages();

/// Lets threads that are made from now on take their memory of the same heap, of which large pages are used:
/// where few threads allocate, and seldom at the same time.
void use_one_heap();

}  // namespace credence::internal
