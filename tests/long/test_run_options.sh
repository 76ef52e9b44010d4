#!/bin/sh
# tests/run.sh refuses an option that is none of its own and none of ctest's, before it builds anything.
#   test_run_options.sh SOURCE_FOLDER
set -eu

run=$1/tests/run.sh
refused()
{
    status=0
    message=$(sh "$run" "$@" 2>&1) || status=$?
    if [ "$status" -ne 2 ] || [ "$(echo "$message" | wc -l)" -ne 1 ]; then
        echo "tests/run.sh $*: status $status, $message"
        exit 1
    fi
}

refused --lnog
refused --long --verbsoe
refused --sanitize adress
sh "$run" --help | grep -q -e '--long'
