#!/bin/sh
# qc-preload of one precision ends a program of the other one at once, with a message, and changes nothing in a program
# without Bullet. It exports the functions of btDbvtBroadphase that Bullet's library exports, and nothing else.
# test_preload_precision.sh PRELOAD PROGRAM_OF_THE_SAME_PRECISION PROGRAM_OF_THE_OTHER PRELOAD_OF_THE_OTHER
set -eu

preload=$1
# A sanitizer's library has to come first.
preloads="$(ldd "$1" | awk '$1 ~ /^lib[at]san/ { print $3 }') $1"
same=$2
other=$3
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

if LD_PRELOAD="$preloads" "$other" >"$work/output" 2>"$work/messages"; then
    echo "$other ran with $preload" >&2
    exit 1
fi
cat "$work/messages"
grep -q "^qc-preload: /.* is Bullet in .* precision; preload ${4##*/} instead of /.*\.so\.\$" "$work/messages"
[ ! -s "$work/output" ]

[ "$(LD_PRELOAD="$preloads" sh -c 'echo fine')" = fine ]

bullet=$(ldd "$same" | awk '$1 ~ /^libBulletCollision/ { print $3 }')
nm -D --defined-only "$bullet" | awk '/16btDbvtBroadphase/ { print $3 }' | sort >"$work/theirs"
nm -D --defined-only "$preload" | awk '{ print $3 }' | sort >"$work/ours"
[ -s "$work/theirs" ]
cmp "$work/theirs" "$work/ours"
echo "$(wc -l <"$work/ours") symbols, those of $bullet"
