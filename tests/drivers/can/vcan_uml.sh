#!/usr/bin/env bash
# SPDX-FileCopyrightText: The arpent authors
# SPDX-License-Identifier: BSD-3-Clause
#
# The SocketCAN port, and can-utils against the driver, on a real virtual CAN interface: in user-mode Linux, where this
# machine's own kernel has no CAN. Installs the packages of group vcan. Usage: tests/drivers/can/vcan_uml.sh [BUILD].
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../../.." && pwd)
build=${1:-$root/build/release}

status=0
check() { "$@" || { echo "FAILED: $*"; status=1; }; }
only_zero_commands() { ! grep 'vcan0 111#' "$1" | grep -qv '111#0000000000000000'; }

inside() {
  export PATH=/usr/sbin:/usr/bin:/sbin:/bin
  mount -t proc none /proc && mount -t sysfs none /sys && mount -t tmpfs none /tmp && mount -t tmpfs none /run
  local modules=/usr/lib/uml/modules/$(uname -r)/kernel module
  for module in net/can/can net/can/can-raw drivers/net/can/dev/can-dev drivers/net/can/vcan; do insmod "$modules/$module.ko"; done
  ip link set lo up && ip route add 224.0.0.0/4 dev lo
  echo "== kernel $(uname -r)"
  echo "== socketcan_test"
  check "$build/tests/socketcan_test" --gtest_brief=0 >/tmp/socketcan
  grep -E '^\[ +(OK|FAILED|SKIPPED|PASSED) |^FAILED' /tmp/socketcan
  check grep -q 'PASSED.* 6 tests' /tmp/socketcan # none skipped
  drive_with_can_utils
  echo "exit $status"
}

# The chassis here is cansend; what the driver says is what candump sees.
drive_with_can_utils() {
  echo "== can-utils against base_driver_process"
  ip link add dev vcan0 type vcan && ip link set vcan0 up
  local bin=$build/bin url='udpm://239.255.76.67:7667?ttl=0'
  candump -L vcan0 >/tmp/candump &
  "$bin/base_driver_process" --set "robot=$root/config/robots/wifibot.yaml" --set port=vcan0 --lcm-url "$url" --run-for-s 60 2>/tmp/driver &
  local driver=$! i
  # Signs of life every 100 ms, with the count that goes on.
  for i in $(seq 0 255); do printf '(%d.%06d) vcan0 211#000000FA000000%02X\n' $((i / 10)) $((i % 10 * 100000)) "$i"; done >/tmp/life
  canplayer -I /tmp/life -l i &
  sleep 1
  cansend vcan0 211#00 # wrong size: counted, harmless
  cansend vcan0 311#0000000000000000
  check "$bin/arpent-base" arm --lcm-url "$url"
  cansend vcan0 311#0000006400000064 # 100 mm on both sides
  sleep 0.5
  check "$bin/arpent-base" status --lcm-url "$url"
  echo "-- the interface goes down for a second"
  ip link set vcan0 down; sleep 1; check "$bin/arpent-base" status --lcm-url "$url"
  ip link set vcan0 up
  canplayer -I /tmp/life -l i & # the first one ended with the interface
  local life=$!
  sleep 1
  check "$bin/arpent-base" release --lcm-url "$url"
  check "$bin/arpent-base" arm --lcm-url "$url"
  check "$bin/arpent-base" stop --lcm-url "$url"
  kill $life $driver; wait $driver || true
  grep -v 'does not answer' /tmp/driver
  echo "zero commands in candump's log: $(grep -c 'vcan0 111#0000000000000000' /tmp/candump), requests for CAN mode: $(grep -c 'vcan0 421#01' /tmp/candump)"
  check grep -q 'vcan0 111#0000000000000000' /tmp/candump
  check only_zero_commands /tmp/candump

  echo "== can-mock and base_driver_process on vcan0"
  candump -L vcan0 >/tmp/candump &
  local dump=$!
  "$bin/arpent-can-mock" --listen vcan0 --quiet --run-for-s 6 </dev/null &
  "$bin/base_driver_process" --set "robot=$root/config/robots/wifibot.yaml" --set port=vcan0 --lcm-url "$url" --run-for-s 6 2>/tmp/driver &
  driver=$!
  sleep 2
  check "$bin/arpent-base" arm --lcm-url "$url"
  sleep 1
  check "$bin/arpent-base" status --lcm-url "$url"
  wait $driver
  kill $dump
  check grep -m1 'vcan0 421#01' /tmp/candump
  check grep -m1 'vcan0 311#' /tmp/candump
}

if [ "${1:-}" = --inside ]; then
  build=$2
  inside 2>&1 | tee "$3" >/dev/console || true
  sync
  poweroff -f
fi

ARPENT_YES=1
source "$root/tools/entrance/entrance.sh"
ensure_packages vcan
cmake --build "$build" --target socketcan_test base_driver_process arpent-base arpent-can-mock >&2
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
cat >"$scratch/init.sh" <<INIT
#!/bin/bash
mount -t tmpfs none /mnt 2>/dev/null
mount -t hostfs -o "$scratch" none /mnt
exec bash "$root/tests/drivers/can/vcan_uml.sh" --inside "$build" /mnt/output
INIT
chmod +x "$scratch/init.sh"
timeout 120 linux.uml mem=512M root=/dev/root rootfstype=hostfs ro "init=$scratch/init.sh" con=null con0=null,fd:1 quiet >"$scratch/console" 2>&1 || true
cat "$scratch/output" 2>/dev/null || { cat "$scratch/console"; echo "user-mode Linux did not run"; exit 1; }
grep -qx 'exit 0' "$scratch/output"
