#!/bin/sh
# Installs what is missing (Debian, Ubuntu), builds into build/, runs every test. Arguments go to ctest:
#     tests/run.sh -R exact
# A test fails where a GL device doesn't open whose packages are installed; QC_TEST_DEVICES names others to require, as
#     QC_TEST_DEVICES=egl,surfaceless tests/run.sh
# on a machine with a GPU. Under sanitizers, in a build folder of their own (presets/README.md):
#     tests/run.sh --sanitize address|thread|memory [CTEST_ARGUMENT...]
# The long form of tests/long, and the fuzzers, for a minute each; both print what they have done. It takes half an hour:
#     tests/run.sh --long [CTEST_ARGUMENT...]
set -eu

root=$(CDPATH='' cd -- "$(dirname -- "$0")/.." && pwd)
preset=
long=
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
    --long)
        long=yes
        shift
        ;;
esac
# ctest passes over options that it does not have.
for argument in "$@"; do
    case $argument in
        --*)
            if ! ctest --help | grep -qE -- "(^|[ ,])${argument%%=*}([ ,=]|\$)"; then
                echo "tests/run.sh: there is no option '$argument'; try --help" >&2
                exit 2
            fi
            ;;
    esac
done
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
    # A user's programs, without the sanitizer, don't link what is built for it.
    left_out='^test_packaging'
    if [ "$preset" = memory ]; then
        qc_hide_gl "$qc_folder/no-gl"
        # Its stand-ins for libraries open the drivers.
        left_out="$left_out|^test_gl_libraries"
    fi
    # They unload Mesa's library, which the sanitizer's list of libraries doesn't allow.
    [ "$preset" != thread ] || left_out="$left_out|^test_gl_devices_that_are_required|^test_view\$"
    set -- --timeout 6000 --exclude-regex "$left_out" "$@"
else
    qc_build "$root" all -DQC_BUILD_TESTS=ON -DQC_BUILD_DEMOS=ON -DQC_BUILD_BULLET=ON \
        "-DQC_WARNINGS_AS_ERRORS=${QC_WARNINGS_AS_ERRORS-ON}"
fi
if [ -n "$long" ]; then
    failed=0
    QC_TEST_LONG=yes CK_TIMEOUT_MULTIPLIER=20 ctest --test-dir "$root/build" --verbose --timeout 6000 \
        --label-regex long --parallel "$(nproc)" "$@" || failed=$?
    sh "$root/tests/fuzz/run.sh" || failed=$?
    exit "$failed"
fi
QC_TEST_DEVICES=${QC_TEST_DEVICES-$(qc_gl_devices)}
export QC_TEST_DEVICES
# One more than there are cores: tests of windows and of devices wait at times.
exec ctest --test-dir "${qc_folder-$root/build}" --output-on-failure --parallel "$(($(nproc) + 1))" "$@"
