#!/usr/bin/env bash
# SPDX-FileCopyrightText: The arpent authors
# SPDX-License-Identifier: BSD-3-Clause
#
# Every C++ file is as clang-format 14 would have it.
cd "$(dirname "${BASH_SOURCE[0]}")/../.." || exit 2
format=$(command -v clang-format-14 || command -v clang-format) || { echo "clang-format is not installed"; exit 77; }
git ls-files '*.cpp' '*.h' | xargs -r ls 2>/dev/null | xargs -r "$format" --dry-run -Werror 2>&1 | grep -E 'error:' | cut -d: -f1 | sort -u | sed 's/^/not formatted: /' | tee /dev/stderr | (! grep -q .)
