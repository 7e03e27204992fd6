#!/usr/bin/env bash
# SPDX-FileCopyrightText: The arpent authors
# SPDX-License-Identifier: BSD-3-Clause
#
# Checks what bites users of LCM and of real-time loops on this machine, and prints the command that mends it. Exit code 1 if
# something must be mended, 0 if the stack can run (warnings included).
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
source "$root/tools/entrance/entrance.sh"
case "${1:-}" in -h | --help) echo "usage: ./arpent doctor    checks this machine and prints how to mend it"; exit 0 ;; esac

failures=0
ok() { printf '  ok    %s\n' "$1"; }
warn() { printf '  warn  %s\n        fix: %s\n' "$1" "$2"; }
fail() { printf '  FAIL  %s\n        fix: %s\n' "$1" "$2"; failures=$((failures + 1)); }

echo "packages"
mapfile -t missing < <(missing_packages build)
if [ ${#missing[@]} -eq 0 ]; then ok "all build packages are installed"; else
  fail "missing: ${missing[*]}" "apt-get install --no-install-recommends ${missing[*]}"
fi
mapfile -t missing < <(missing_packages test)
[ ${#missing[@]} -eq 0 ] && ok "all test packages are installed" ||
  warn "missing, some tests will skip: ${missing[*]}" "apt-get install --no-install-recommends ${missing[*]}"

echo "processor"
case "$(uname -m)" in
  x86_64) grep -qw avx2 /proc/cpuinfo && ok "AVX2" ||
    fail "no AVX2: the default build does not run here" "cmake --preset portable" ;;
  *) ok "$(uname -m): portable code" ;;
esac

echo "multicast (LCM)"
route=$(ip route get 239.255.76.67 2>/dev/null)
if [ -z "$route" ]; then
  fail "no route for multicast: LCM cannot open its bus" "ip link set lo up && ip route add 224.0.0.0/4 dev lo"
elif grep -q 'dev lo' <<<"$route"; then ok "224.0.0.0/4 is routed over loopback"; else
  warn "multicast goes over $(sed -n 's/.*dev \([^ ]*\).*/\1/p' <<<"$route"): large messages are cut to its packet size, and others on that network can send to this bus" \
    "ip route add 224.0.0.0/4 dev lo"
fi

echo "receive buffers"
rmem=$(cat /proc/sys/net/core/rmem_max 2>/dev/null || echo 0)
if [ "$rmem" -ge 4194304 ]; then ok "net.core.rmem_max = $rmem"; else
  fail "net.core.rmem_max = $rmem: stereo pairs of 650 kB will be lost" \
    "sysctl -w net.core.rmem_max=4194304; echo net.core.rmem_max=4194304 >/etc/sysctl.d/60-arpent.conf"
fi
ipfrag=$(cat /proc/sys/net/ipv4/ipfrag_time 2>/dev/null || echo 30)
if [ "$ipfrag" -le 3 ]; then ok "net.ipv4.ipfrag_time = $ipfrag"; else
  warn "net.ipv4.ipfrag_time = $ipfrag: after an overload, fragmented messages are lost for that many seconds" "sysctl -w net.ipv4.ipfrag_time=1"
fi

echo "real time (base driver)"
if [ "$(id -u)" -eq 0 ] || [ "$(ulimit -r)" != 0 ]; then ok "SCHED_FIFO is permitted"; else
  warn "SCHED_FIFO is not permitted: control loops will jitter under load" \
    "echo '@robot - rtprio 80' >>/etc/security/limits.d/arpent.conf, and log in again"
fi
lock=$(ulimit -l)
if [ "$lock" = unlimited ] || [ "$(id -u)" -eq 0 ]; then ok "memory may be locked"; else
  warn "only $lock kB of memory may be locked" "echo '@robot - memlock unlimited' >>/etc/security/limits.d/arpent.conf, and log in again"
fi

echo "network namespaces (live tests)"
if unshare -n true 2>/dev/null || unshare -Urn true 2>/dev/null; then ok "permitted"; else
  warn "not permitted: live tests run on loopback with ports of their own" "sysctl -w kernel.unprivileged_userns_clone=1"
fi

echo "test data"
if [ -n "${ARPENT_DATA:-}" ] && [ -d "$ARPENT_DATA" ]; then ok "ARPENT_DATA = $ARPENT_DATA"; else
  ok "ARPENT_DATA is not set: tests on public data skip, all else works"
fi

[ "$failures" -eq 0 ] && echo "This machine is ready." || { echo "$failures to mend before the stack runs well."; exit 1; }
