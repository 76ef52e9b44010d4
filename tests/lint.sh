#!/bin/sh
# Looks for defects without running anything: clang-format (layout of all sources), clang-tidy and cppcheck (the core;
# .clang-tidy has the checks), shellcheck (scripts). Fails on any finding. Files of the core may be named:
#     tests/lint.sh plugin/scene/bodies.c
set -eu

root=$(CDPATH='' cd -- "$(dirname -- "$0")/.." && pwd)
case ${1-} in
    -h | --help)
        sed -n '2,/^set/s/^# \{0,1\}//p' "$0"
        exit 0
        ;;
    -*)
        echo "tests/lint.sh: there is no option '$1'; try --help" >&2
        exit 2
        ;;
esac
cd "$root"
for file in "$@"; do
    if [ ! -f "$file" ]; then
        echo "tests/lint.sh: there is no file '$file'" >&2
        exit 2
    fi
done
# shellcheck source=/dev/null
. tests/setup.sh
qc_install build lint
# With asserts: they are what the analyser knows of our invariants.
qc_folder=$root/build-lint
qc_build "$root" qc_objects -DCMAKE_BUILD_TYPE=Debug -DQC_BUILD_TESTS=OFF -DQC_BUILD_DEMOS=OFF -DQC_BUILD_BULLET=OFF
if [ $# -eq 0 ]; then
    find bullet_glue demos include plugin tests \( -name '*.c' -o -name '*.cpp' -o -name '*.h' \) -print0 |
        xargs -0 clang-format --dry-run --Werror
    find . \( -name '*.sh' -o -path ./.ci/run \) -not -path './build*' -print0 | xargs -0 shellcheck --severity=warning
fi
[ $# -gt 0 ] || set -- plugin
# stage_switches.c is no part of the library, and needs the definition that qc-ablation is compiled with.
find "$@" -name '*.c' -not -name stage_switches.c -print0 |
    xargs -0 -n 1 -P "$(nproc)" clang-tidy --quiet -p "$qc_folder"
# Wrong for this code: members of arrays of arrays that a call sets are no reads (uninitvar); the library of a driver
# stays open (resourceLeak); a right shift keeps the sign with gcc and clang; hexadecimal floats are not read.
cppcheck -j "$(nproc)" --quiet --error-exitcode=1 --std=c17 --library=posix --enable=warning,performance,portability \
    --max-configs=4 --suppress=uninitvar --suppress=resourceLeak:plugin/gl/device_egl.c \
    --suppress=shiftTooManyBitsSigned:plugin/broadphase/bvh_build_order.h \
    --suppress=incorrectLogicOperator:plugin/base/scalar.h -Iinclude -Iplugin "$@"
