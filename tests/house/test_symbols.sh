#!/bin/sh
# A shared library shows its own names and no others: not the instances of templates that it is made of.
# Names of sanitizers don't count.
# test_symbols.sh PREFIX LIBRARY...    PREFIX: what each name begins with
set -eu

prefix=$1
shift
own="^((vtable|VTT|typeinfo|typeinfo name) for |(non-)?(virtual )?thunk to )?$prefix"
broken=0
for library in "$@"; do
    # Also functions that a header alone would give weak, and objects that are one in the whole process.
    nm -D --defined-only -C "$library" | cut -d ' ' -f 3- | grep -vE '^__(a|m|t|ub)san_' >"${TMPDIR:-/tmp}/symbols.$$"
    if ! grep -qE "$own" "${TMPDIR:-/tmp}/symbols.$$"; then
        echo "$library shows none of its own names"
        broken=1
    fi
    if grep -vE "$own" "${TMPDIR:-/tmp}/symbols.$$"; then
        echo "  are not the own names of $library"
        broken=1
    fi
    rm -f "${TMPDIR:-/tmp}/symbols.$$"
done
exit "$broken"
