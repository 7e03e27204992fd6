#!/usr/bin/env bash
# SPDX-FileCopyrightText: The arpent authors
# SPDX-License-Identifier: BSD-3-Clause
#
# docs/MAP.md names every process, message and channel, and the documents name only files that exist.
cd "$(dirname "${BASH_SOURCE[0]}")/../.." || exit 2
status=0
for name in $(ls lcmtypes/*.lcm | xargs -n1 basename | sed 's/\.lcm//') \
            $(grep -ohE '"[A-Z_]+"' common/channels.h | tr -d '"') \
            $(grep -rhoE 'kName\[\] = "\w+"' perception mapping planning control drivers sim link | grep -oE '\w+_process'); do
  grep -qw -- "$name" docs/MAP.md || { echo "docs/MAP.md does not name $name"; status=1; }
done
for file in $(grep -ohE '\]\((docs|bench|LICENSE)[^)]*\)' README.md | tr -d '()' | sed 's/^]//'); do
  [ -e "$file" ] || { echo "README.md names $file, which is not there"; status=1; }
done
for verb in $(grep -oE '\./arpent [a-z-]+' README.md docs/*.md | awk '{print $2}' | sort -u); do
  grep -qE "(^|[ |])$verb( |\)|$)" arpent || { echo "documents name the verb $verb, which ./arpent does not know"; status=1; }
done
exit $status
