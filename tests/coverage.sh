#!/bin/sh
# Which lines of the core its tests run: a table by room in the terminal, each line that is not run in
# build-coverage/coverage.html. Fails below 95 % of the core's lines. Arguments go to ctest:
#     tests/coverage.sh -R recording
# Tests that take part: those of the core, not those of Bullet's glue, of the demos and of the house: 28 minutes on two
# cores beside other work. What is not run, and why: tests/README.md.
set -eu

root=$(CDPATH='' cd -- "$(dirname -- "$0")/.." && pwd)
case ${1-} in
    -h | --help)
        sed -n '2,/^set/s/^# \{0,1\}//p' "$0"
        exit 0
        ;;
esac
# shellcheck source=/dev/null
. "$root/tests/setup.sh"
qc_install build tests coverage
qc_folder=$root/build-coverage
qc_build "$root" all -C "$root/tests/presets/coverage.cmake"
find "$qc_folder" -name '*.gcda' -delete
QC_TEST_DEVICES=${QC_TEST_DEVICES-$(qc_gl_devices)}
export QC_TEST_DEVICES
export QC_TEST_FILES="${QC_TEST_FILES-500}"
# A test that fails here fails in tests/run.sh, too; what it ran counts.
ctest --test-dir "$qc_folder" --parallel "$(nproc)" --label-exclude house "$@" || echo "Some tests failed." >&2
cd "$root"
status=0
gcovr --root . --object-directory "$qc_folder" --filter plugin/ -j "$(nproc)" --gcov-ignore-parse-errors \
    --csv "$qc_folder/coverage.csv" --html-details "$qc_folder/coverage.html" --fail-under-line 95 \
    "$qc_folder/plugin" || status=$?
awk -F, '
    NR > 1 { split($1, path, "/"); lines[path[2]] += $2; run[path[2]] += $3; all += $2; ran += $3 }
    END {
        for (room in lines)
            printf "%-12s %6d lines %6.1f %%\n", room, lines[room], 100 * run[room] / lines[room] | "sort"
        close("sort")
        printf "%-12s %6d lines %6.1f %%\n", "core", all, 100 * ran / all
    }' "$qc_folder/coverage.csv"
exit "$status"
