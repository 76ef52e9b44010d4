#!/bin/sh
# Installs what is missing (Debian, Ubuntu), builds into build/, runs every test. Arguments go to ctest:
#     tests/run.sh -R exact
# A test fails where a GL device doesn't open whose packages are installed; QC_TEST_DEVICES names others to require, as
#     QC_TEST_DEVICES=egl,surfaceless tests/run.sh
# on a machine with a GPU. Under sanitizers, in a build folder of their own (presets/README.md):
#     tests/run.sh --sanitize address|thread|memory [CTEST_ARGUMENT...]
set -eu

root=$(CDPATH='' cd -- "$(dirname -- "$0")/.." && pwd)
preset=
case ${1-} in
    -h | --help)
        sed -n '2,/^set/s/^# \{0,1\}//p' "$0"
        exit 0
        ;;
    --sanitize)
        preset=${2-}
        case $preset in
            address | thread | memory) shift 2 ;;
            *)
                echo "tests/run.sh: --sanitize takes address, thread or memory, not '$preset'; try --help" >&2
                exit 2
                ;;
        esac
        ;;
    --sa*)
        echo "tests/run.sh: there is no option '$1'; try --help" >&2
        exit 2
        ;;
esac
# shellcheck source=/dev/null
. "$root/tests/setup.sh"

# shellcheck disable=SC2034 # Read by qc_install.
qc_wishes="clients docs view display ${qc_wishes-}"
[ "$preset" != memory ] || qc_wishes="clang $qc_wishes"
qc_install build tests
if [ -n "$preset" ]; then
    # shellcheck source=/dev/null
    . "$root/tests/presets/environment.sh"
    qc_folder=$root/build-$preset
    qc_build "$root" all -C "$root/tests/presets/$preset.cmake" -DQC_BUILD_TESTS=ON
else
    qc_build "$root" all -DQC_BUILD_TESTS=ON -DQC_BUILD_DEMOS=ON -DQC_BUILD_BULLET=ON
fi
QC_TEST_DEVICES=${QC_TEST_DEVICES-$(qc_gl_devices)}
export QC_TEST_DEVICES
exec ctest --test-dir "${qc_folder-$root/build}" --output-on-failure --parallel "$(nproc)" "$@"
