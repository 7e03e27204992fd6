// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "common/memory.h"

#include <cstdlib>  // any header of the C library says whether it is glibc

#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace arpent {

void keep_freed_memory() {
#ifdef __GLIBC__
  constexpr int kLargestOnHeap = 32 << 20;  // glibc takes no more
  constexpr int kKeptAtTheTop = 256 << 20;
  mallopt(M_MMAP_THRESHOLD, kLargestOnHeap);
  mallopt(M_TRIM_THRESHOLD, kKeptAtTheTop);
#endif
}

}  // namespace arpent
