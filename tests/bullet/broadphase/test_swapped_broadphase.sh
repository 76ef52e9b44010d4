#!/bin/sh
# A program whose names for Bullet's broadphases were made ours prints the same, and did use ours.
# test_swapped_broadphase.sh PLAIN SWAPPED
set -eu

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

"$1" >"$work/plain"
"$2" >"$work/swapped" 2>"$work/used"
[ -s "$work/plain" ]
cmp "$work/plain" "$work/swapped"
[ "$(grep -c '^qcBroadphase$' "$work/used")" = 2 ]
echo "the same $(wc -l <"$work/plain") lines"
