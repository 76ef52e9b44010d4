#!/bin/sh
# A program for Bullet alone prints the same with and without qc-preload, and with it qcBroadphase does the work.
# test_preload.sh PROGRAM PRELOAD
set -eu

program=$1
# A sanitizer's library has to come first.
preload="$(ldd "$2" | awk '$1 ~ /^lib[at]san/ { print $3 }') $2"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

fail()
{
    echo "$*" >&2
    exit 1
}

"$program" >"$work/without" 2>"$work/messages"
[ -s "$work/without" ] || fail "$program prints nothing"
[ ! -s "$work/messages" ] || fail "$(cat "$work/messages")"

LD_PRELOAD="$preload" "$program" >"$work/with" 2>"$work/messages"
cmp "$work/without" "$work/with" || fail "$(diff "$work/without" "$work/with" | head -20)"
[ ! -s "$work/messages" ] || fail "statistics without QC_PRELOAD_STATISTICS: $(cat "$work/messages")"

LD_PRELOAD="$preload" QC_PRELOAD_STATISTICS=1 "$program" >"$work/with" 2>"$work/messages"
cmp "$work/without" "$work/with"
cat "$work/messages"
grep -Eq '^qc-preload: [1-9][0-9]* broadphases, [1-9][0-9]* proxies, [1-9][0-9]* boxes set, [1-9][0-9]* searches' \
    "$work/messages" || fail "no statistics of qcBroadphase"
echo "the same $(wc -l <"$work/with") lines"
