#!/usr/bin/env bash
# SPDX-FileCopyrightText: The arpent authors
# SPDX-License-Identifier: BSD-3-Clause
#
# Builds the fuzz targets with clang and runs each for so many seconds (default 10): tests/fuzz/run.sh [SECONDS]. Exit code 77: clang is not installed.
set -euo pipefail
seconds=${1:-10}
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
command -v clang++-14 >/dev/null || { echo "clang++-14 is not installed: fuzzing is left out"; exit 77; }
cmake --preset fuzz >/dev/null
cmake --build build/fuzz --target fuzz_guard fuzz_log fuzz_config
corpus=$(mktemp -d)
trap 'rm -rf "$corpus"' EXIT
for target in guard log config; do
  mkdir "$corpus/$target"
  [ "$target" != config ] || cp config/rigs/*.yaml "$corpus/config"
  echo "== fuzz_$target, $seconds s"
  if ! build/fuzz/bin/fuzz_$target -max_total_time="$seconds" -max_len=4096 -rss_limit_mb=2048 -timeout=10 -print_final_stats=1 \
    -artifact_prefix="$corpus/" "$corpus/$target" >"$corpus/output" 2>&1; then
    tail -60 "$corpus/output"
    exit 1
  fi
  grep 'number_of_executed_units' "$corpus/output"
done
