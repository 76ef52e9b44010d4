#!/bin/sh
# Installs what is missing (Debian, Ubuntu), builds into build/, runs every test. Arguments go to ctest:
#     tests/run.sh -R exact
# A test fails where a GL device doesn't open whose packages are installed; QC_TEST_DEVICES names others to require, as
#     QC_TEST_DEVICES=egl,surfaceless tests/run.sh
# on a machine with a GPU.
set -eu

root=$(CDPATH='' cd -- "$(dirname -- "$0")/.." && pwd)
# shellcheck source=/dev/null
. "$root/tests/setup.sh"

# shellcheck disable=SC2034 # Read by qc_install.
qc_wishes="clients docs view display ${qc_wishes-}"
qc_install build tests
qc_build "$root" all -DQC_BUILD_TESTS=ON -DQC_BUILD_DEMOS=ON -DQC_BUILD_BULLET=ON
QC_TEST_DEVICES=${QC_TEST_DEVICES-$(qc_gl_devices)}
export QC_TEST_DEVICES
exec ctest --test-dir "$root/build" --output-on-failure --parallel "$(nproc)" "$@"
