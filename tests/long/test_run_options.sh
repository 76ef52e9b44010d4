#!/bin/sh
# tests/run.sh refuses an option that is none of its own and none of ctest's, before it builds anything; tests/dragon.sh
# refuses one before it fetches anything.
#   test_run_options.sh SOURCE_FOLDER
set -eu

tests=$1/tests
refused()
{
    script=$1
    shift
    status=0
    message=$(sh "$tests/$script" "$@" 2>&1) || status=$?
    if [ "$status" -ne 2 ] || [ "$(echo "$message" | wc -l)" -ne 1 ]; then
        echo "tests/$script $*: status $status, $message"
        exit 1
    fi
}

refused run.sh --lnog
refused run.sh --long --verbsoe
refused run.sh --sanitize adress
refused dragon.sh --burte
sh "$tests/run.sh" --help | grep -q -e '--long'
sh "$tests/dragon.sh" --help | grep -q -e '--brute'
