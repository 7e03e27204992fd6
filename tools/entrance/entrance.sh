# SPDX-FileCopyrightText: The arpent authors
# SPDX-License-Identifier: BSD-3-Clause
#
# What ./arpent does before it runs a verb: packages, configuration, build. Sourced, with $root and $build set.

# The Debian packages of the given groups (packages.txt) that are not installed.
missing_packages() {
  local group package
  for group in "$@"; do
    while read -r package; do
      dpkg-query -W -f='${Status}' "$package" 2>/dev/null | grep -q 'ok installed' || echo "$package"
    done < <(awk -v g="$group" '$1 == g {print $2}' "$root/tools/entrance/packages.txt")
  done
}

ensure_packages() {
  command -v dpkg-query >/dev/null || return 0
  local missing
  mapfile -t missing < <(missing_packages "$@")
  [ ${#missing[@]} -eq 0 ] && return 0
  echo "arpent: these Debian packages are missing: ${missing[*]}" >&2
  if [ -z "${ARPENT_YES:-}" ] && [ -t 0 ]; then
    local answer
    read -r -p "Install them with apt-get? [Y/n] " answer
    case "$answer" in [nN]*) echo "arpent: stopped; install them and come again" >&2; exit 2 ;; esac
  fi
  local sudo=()
  [ "$(id -u)" -eq 0 ] || sudo=(sudo)
  "${sudo[@]}" apt-get update -qq &&
    DEBIAN_FRONTEND=noninteractive "${sudo[@]}" apt-get install -y -qq --no-install-recommends "${missing[@]}" >&2 ||
    { echo "arpent: apt-get could not install them; see above" >&2; exit 2; }
}

build_targets() {
  local configured
  configured=$(cd "$root" && cmake --preset release 2>&1) || { echo "$configured" >&2; exit 2; }
  NINJA_STATUS='building [%f/%t] ' cmake --build "$build" --target "$@" >&2 ||
    { echo "arpent: the build failed; see above" >&2; exit 2; }
}

run_tests() {
  build_targets all
  cd "$root"
  exec ctest --test-dir "$build" -j "$(nproc)" --output-on-failure "$@"
}

# The benchmarks that there are.
bench_names() { grep -rhoE 'arpent_bench\((\w+)' "$root/bench" --include=CMakeLists.txt | sed 's/.*(//' | sort; }

run_benches() {
  local names=() json="" rest=()
  while [ $# -gt 0 ]; do
    case "$1" in
      --json) json=${2:?--json needs a file}; shift 2 ;;
      -h | --help) echo "usage: ./arpent bench [NAME …] [--json FILE]"; echo "names: $(bench_names | tr '\n' ' ')"; exit 0 ;;
      -*) rest+=("$1"); shift ;;
      *) names+=("$1"); shift ;;
    esac
  done
  [ ${#names[@]} -gt 0 ] || mapfile -t names < <(bench_names)
  local name parts=()
  for name in "${names[@]}"; do
    bench_names | grep -qx "$name" ||
      { echo "arpent: there is no bench '$name'; there are: $(bench_names | tr '\n' ' ')" >&2; exit 2; }
  done
  build_targets arpent_programs "${names[@]/#/bench_}"
  local scratch
  scratch=$(mktemp -d)
  trap "rm -rf '$scratch'" EXIT
  for name in "${names[@]}"; do
    echo "== $name"
    "$build/bin/bench_$name" --json "$scratch/$name.json" "${rest[@]}"
    parts+=("$scratch/$name.json")
  done
  [ -z "$json" ] || python3 -c '
import json, sys
rows = [row for part in sys.argv[2:] for row in json.load(open(part))]
open(sys.argv[1], "w").write(json.dumps(rows, indent=1) + "\n")' "$json" "${parts[@]}"
}
