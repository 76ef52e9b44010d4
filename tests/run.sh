#!/bin/sh
# Installs what is missing (Debian, Ubuntu), builds into build/, runs every test. Arguments go to ctest:
#     tests/run.sh -R exact
set -eu

root=$(CDPATH='' cd -- "$(dirname -- "$0")/.." && pwd)
# shellcheck source=/dev/null
. "$root/tests/setup.sh"

# shellcheck disable=SC2034 # Read by qc_install.
qc_wishes=clients
qc_install build tests
qc_build "$root" all -DQC_BUILD_TESTS=ON -DQC_BUILD_DEMOS=ON -DQC_BUILD_BULLET=ON
exec ctest --test-dir "$root/build" --output-on-failure --parallel "$(nproc)" "$@"
