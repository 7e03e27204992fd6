#!/usr/bin/env bash
# SPDX-FileCopyrightText: The arpent authors
# SPDX-License-Identifier: BSD-3-Clause
#
# The layer lint: libraries do not know LCM, and the arrows between rooms run one way (docs/MAP.md).
cd "$(dirname "${BASH_SOURCE[0]}")/../.." || exit 2
status=0
complain() { [ -z "$2" ] || { echo "$1:"; sed 's/^/  /' <<<"$2"; status=1; }; }

sources() { find "$@" -name '*.h' -o -name '*.cpp' | sort; }
# Only common's bus, a room's wire and process, tools and console know LCM.
libraries=$(sources common drivers perception mapping planning control calib sim link | grep -vE '/process/|/wire\.(h|cpp)$|^common/(bus/|image_codec)')
complain "libraries that include LCM or its messages" "$(grep -nE '#include <(lcm|arpent)/' $libraries)"
complain "libraries that include wire, process or bus" "$(grep -nE '#include ".*(/wire\.h|/process/|^common/bus/)' $libraries | grep -v '^common/wire_schema')"
complain "common includes another room" "$(grep -nE '#include "(perception|mapping|planning|control|sim|drivers|tools)/' $(sources common))"
complain "perception includes mapping, planning, sim or tools" "$(grep -nE '#include "(mapping|planning|control|sim|drivers|tools)/' $(sources perception))"
complain "mapping includes planning, sim, drivers or tools" "$(grep -nE '#include "(planning|control|sim|drivers|tools)/' $(sources mapping))"
complain "planning's library takes more than common, mapping and perception's value types" \
  "$(grep -nE '#include "(perception|control|sim|drivers|tools)/' $(sources planning | grep -vE '/process/|/wire\.(h|cpp)$') | grep -v 'perception/stereo/depth_map.h')"
complain "sim includes a room above it" "$(grep -nE '#include "(perception|mapping|planning|control|tools)/' $(sources sim))"
complain "mapping's library takes more from perception than value types" \
  "$(grep -nE '#include "perception/' $(sources mapping/tsdf mapping/surface) | grep -v 'perception/stereo/depth_map.h')"
complain "drivers include a room above them" "$(grep -nE '#include "(perception|mapping|planning|control|sim|tools)/' $(sources drivers))"
complain "link takes more than common" "$(grep -nE '#include "(perception|mapping|planning|control|calib|sim|drivers|tools)/' $(sources link))"
complain "calib takes more than common and perception" "$(grep -nE '#include "(mapping|planning|control|sim|drivers|tools)/' $(sources calib))"
complain "mains longer than 30 lines" "$(for f in $(find drivers perception mapping link -name '*_main.cpp'); do [ "$(wc -l <"$f")" -le 30 ] || echo "$f"; done)"
complain "files over 500 lines" "$(for f in $(git ls-files '*.cpp' '*.h'); do [ ! -f "$f" ] || [ "$(wc -l <"$f")" -le 500 ] || echo "$f"; done)"
complain "files without the two SPDX lines" "$(for f in $(git ls-files '*.cpp' '*.h' '*.sh' '*.cmake' 'CMakeLists.txt' '*/CMakeLists.txt'); do [ ! -f "$f" ] || [ "$(head -3 "$f" | grep -c SPDX)" -eq 2 ] || echo "$f"; done)"
exit $status
