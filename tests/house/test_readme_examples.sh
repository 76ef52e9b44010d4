#!/bin/sh
# Every C and C++ block of README.md stands in a program of demos/hello, line by line; indentation may differ.
# test_readme_examples.sh SOURCE_FOLDER
set -eu

cd "$1"
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT

# Blocks become files block.0, block.1, ...
awk -v folder="$scratch" '
    /^```(c|cpp)$/ { file = folder "/block." count++; next }
    /^```/ { file = "" }
    file != "" { print > file }' README.md

blocks=0
broken=0
for block in "$scratch"/block.*; do
    [ -f "$block" ] || continue
    blocks=$((blocks + 1))
    found=0
    for program in demos/hello/*.c demos/hello/*.cpp; do
        if awk '
            { sub(/^[ \t]+/, "") }
            NR == FNR { block = block "\n" $0; next }
            { program = program "\n" $0 }
            END { exit index(program "\n", block "\n") == 0 }' "$block" "$program"; then
            found=1
        fi
    done
    if [ "$found" -eq 0 ]; then
        echo "No program of demos/hello has these lines of README.md:"
        cat "$block"
        broken=1
    fi
done
echo "$blocks examples"
[ "$blocks" -gt 0 ] || broken=1
exit "$broken"
