#!/bin/sh
# Runs the fuzzers, or those that are named, and prints a table; fails if one of them does.
#     tests/fuzz/run.sh [NAME...] [--runs N | --seconds S] [--keep]
# --runs N, --seconds S: of each fuzzer; 60 seconds by default. --keep: afterwards, minimises all inputs found into
# tests/fuzz/corpus/NAME. Built with clang into build-fuzz/, which keeps what a run finds: inputs/, failures/, logs/.
set -eu

root=$(CDPATH='' cd -- "$(dirname -- "$0")/../.." && pwd)
names=
limit=-max_total_time=60
keep=
refuse()
{
    echo "tests/fuzz/run.sh: $1; try --help" >&2
    exit 2
}
while [ $# -gt 0 ]; do
    case $1 in
        -h | --help)
            sed -n '2,/^set/s/^# \{0,1\}//p' "$0"
            exit 0
            ;;
        --runs | --seconds)
            case ${2-} in
                '' | *[!0-9]* | 0) refuse "$1 takes a number, not '${2-}'" ;;
            esac
            limit=-runs=$2
            [ "$1" = --runs ] || limit=-max_total_time=$2
            shift
            ;;
        --keep) keep=yes ;;
        -*) refuse "there is no option '$1'" ;;
        *) names="$names $1" ;;
    esac
    shift
done
for name in $names; do
    grep -rqs "^ *qc_fuzzer($name " "$root/tests/fuzz" --include=CMakeLists.txt || refuse "there is no fuzzer '$name'"
done

# shellcheck source=/dev/null
. "$root/tests/setup.sh"
qc_install build tests clang
qc_folder=$root/build-fuzz
qc_build "$root" fuzzers -C "$root/tests/fuzz/preset.cmake" -DQC_BUILD_TESTS=ON
cd "$qc_folder"
mkdir -p inputs failures logs
[ -n "$names" ] || names=$(ls fuzzers)

# The tools of the compiler's version, which read its profiles.
compiler=$(sed -n 's/^CMAKE_C_COMPILER:[A-Z]*=//p' CMakeCache.txt)
version=$("$compiler" -dumpversion)
tool()
{
    command -v "$1-${version%%.*}" || echo "$1"
}
# covered NAME PLACE...: lines of these files and folders that the last run reached, in per cent.
covered()
{
    name=$1
    shift
    $(tool llvm-profdata) merge -sparse "logs/$name.profraw" -o "logs/$name.profdata"
    $(tool llvm-cov) report "tests/fuzz_$name" -instr-profile="logs/$name.profdata" "$@" >"logs/$name.coverage"
    awk '$1 == "TOTAL" { print $10 }' "logs/$name.coverage"
}
# value NAME KEY: of libFuzzer's statistics.
value()
{
    sed -n "s/^stat::$2: *//p" "logs/$1.log"
}

failed=0
total=0
echo
printf '%-16s %12s %10s %9s  %s\n' fuzzer executions 'a second' covered result
for name in $names; do
    own=$root/tests/fuzz/corpus/$name
    read -r length room <"fuzzers/$name"
    mkdir -p "inputs/$name" "failures/$name" "$own"
    result=passed
    LLVM_PROFILE_FILE=logs/$name.profraw nice -n 19 "tests/fuzz_$name" "$limit" -max_len="$length" -print_final_stats=1 \
        -artifact_prefix="failures/$name/" "inputs/$name" "$own" >"logs/$name.log" 2>&1 || result='FAILED'
    coverage=-
    if [ "$result" = passed ]; then
        # shellcheck disable=SC2046 # A room is several words.
        coverage=$(covered "$name" $(for place in $room; do echo "$root/$place"; done))
    else
        result="FAILED: see build-fuzz/logs/$name.log"
        failed=1
    fi
    executions=$(value "$name" number_of_executed_units)
    total=$((total + ${executions:-0}))
    printf '%-16s %12s %10s %9s  %s\n' "$name" "${executions:--}" "$(value "$name" average_exec_per_sec)" "$coverage" "$result"
    if [ -n "$keep" ] && [ "$result" = passed ]; then
        rm -rf "logs/$name.kept"
        mkdir "logs/$name.kept"
        LLVM_PROFILE_FILE=/dev/null "tests/fuzz_$name" -set_cover_merge=1 -use_counters=0 -max_len="$length" \
            "logs/$name.kept" "$own" "inputs/$name" >>"logs/$name.log" 2>&1
        rm -f "$own"/*
        cp "logs/$name.kept"/* "$own"
    fi
done
printf '%-16s %12s\n' total "$total"
exit "$failed"
