// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The three kinds of error of the house. A programmer's mistake stops the program (ARPENT_ASSERT, in every build); bad
// input at start throws InputError, which a `main` turns into one line and exit code 2; what may be absent at run time
// is an optional or a result in the signature.
#pragma once

#include <cstdio>
#include <cstdlib>
#include <stdexcept>
#include <string>

namespace arpent {

/// Input that cannot be used: a missing file, a wrong config, an impossible calibration. `what()` is one line that says
/// what is wrong, where, and what to do.
class InputError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace arpent

/// Aborts with file and line if `condition` is false; never compiled out.
#define ARPENT_ASSERT(condition)                                                             \
  do {                                                                                       \
    if (!(condition)) {                                                                      \
      std::fprintf(stderr, "%s:%d: assertion failed: %s\n", __FILE__, __LINE__, #condition); \
      std::abort();                                                                          \
    }                                                                                        \
  } while (false)
