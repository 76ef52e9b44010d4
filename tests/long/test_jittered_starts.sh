#!/bin/sh
# Cloth, piles and a fracture from starts that differ by centimetres: each comes to rest, and then nothing penetrates,
# hangs in the air, or lies under the ground; `qc-bench stability` sees to energy, memory and finite numbers.
# QC_TEST_LONG: ten starts instead of one.
#   test_jittered_starts.sh QC_BENCH
set -eu

starts=1
[ -z "${QC_TEST_LONG-}" ] || starts='1 2 3 4 5 6 7 8 9 10'
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
for start in $starts; do
    "$1" stability --scene cloth,fracture,meshes,boxes,cloth-pile --steps 1200 --jitter "$start" --out "$work" \
        >"$work/log" 2>&1 || {
        cat "$work/log"
        exit 1
    }
    # Columns by name. Kinetic energy at the end: at most 2 % of what the scene has given off.
    awk -F, -v start="$start" '
        NR == 1 { for (i = 1; i <= NF; ++i) column[$i] = i; next }
        !($1 in first) { first[$1] = $column["energy"] }
        { last[$1] = $0 }
        END {
            for (scene in last) {
                ++scenes
                $0 = last[scene]
                most = 0.02 * (first[scene] - $column["energy"]) + 0.05
                isBad = $column["pairs"] != 0 || $column["hanging"] != 0 || $column["below"] > 0.002 || \
                    !($column["kinetic"] <= most)
                bad += isBad
                printf "start %d, %s: %d pairs, %d hang, %g m below the ground, %g J of at most %g%s\n", start, scene,
                    $column["pairs"], $column["hanging"], $column["below"], $column["kinetic"], most, isBad ? ": NO" : ""
            }
            exit bad > 0 || scenes != 5
        }' "$work/stability.csv"
done
