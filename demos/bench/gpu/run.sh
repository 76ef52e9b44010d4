#!/bin/sh
# Shows the GL device of this machine, runs the tests on it, then "qc-bench gpu", with the programs in bin/ beside this
# script. demos/gpu.sh lays the folder out.
set -eu

here=$(CDPATH='' cd -- "$(dirname -- "$0")" && pwd)
bench=$here/bin/qc-bench

# GLVND's loader where the machine has a driver and no loader, and NVIDIA's entry where its package left it out.
use_own_loaders()
{
    if "$bench" gpu --device egl --triangles 0 --out "$out" 2>&1 | grep -q 'no libEGL'; then
        LD_LIBRARY_PATH=$here/gl${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}
        export LD_LIBRARY_PATH
    fi
    system=/etc/glvnd/egl_vendor.d:/usr/share/glvnd/egl_vendor.d
    if [ -z "${__EGL_VENDOR_LIBRARY_DIRS-}${__EGL_VENDOR_LIBRARY_FILENAMES-}" ] &&
        ! ls /etc/glvnd/egl_vendor.d/*nvidia* /usr/share/glvnd/egl_vendor.d/*nvidia* >/dev/null 2>&1; then
        __EGL_VENDOR_LIBRARY_DIRS=$system:$here/gl/egl_vendor.d
        export __EGL_VENDOR_LIBRARY_DIRS
    fi
}

# What there is of a GPU's driver, for whoever looks for the reason.
show_drivers()
{
    echo "Devices: $(find /dev -maxdepth 2 -name 'nvidia[0-9]*' -o -maxdepth 2 -name 'renderD*' | tr '\n' ' ')"
    echo "EGL drivers: $(PATH=$PATH:/sbin:/usr/sbin ldconfig -p | grep -o 'libEGL_[^ ]*' | sort -u | tr '\n' ' ')"
    echo "Entries of EGL drivers: $(find /etc/glvnd /usr/share/glvnd -name '*.json' 2>/dev/null | tr '\n' ' ')"
}

# run_test PROGRAM KIND: its output and its exit status go to $out/tests. All kernels are compiled anew.
run_test()
{
    name=$(basename -- "$1")
    status=0
    QC_TEST_DEVICES=$2 QC_LAYERS_REFINE=device QC_PROGRAM_CACHE=off QC_TEST_LONG=yes \
        "$1" >"$out/tests/$name.txt" 2>&1 || status=$?
    echo "$status" >"$out/tests/$name.status"
}

# run_tests KIND: each test must run on a device of the kind. Several run at a time where there are many cores.
run_tests()
{
    required=$1
    [ "${MESA_LOADER_DRIVER_OVERRIDE-}" != zink ] || required=zink
    jobs=$(($(getconf _NPROCESSORS_ONLN) / 4))
    running=0
    failed=0
    echo "Tests on $required:"
    rm -rf "$out/tests"
    mkdir -p "$out/tests"
    for program in "$here"/bin/test_*; do
        run_test "$program" "$required" &
        running=$((running + 1))
        [ "$running" -lt "$jobs" ] || {
            wait
            running=0
        }
    done
    wait
    for program in "$here"/bin/test_*; do
        name=$(basename -- "$program")
        log=$out/tests/$name.txt
        if [ "$(cat "$out/tests/$name.status")" = 0 ]; then
            echo "  $name: ok"
        else
            echo "  $name: FAILED, see $log"
            tail -n 3 "$log" | sed 's/^/    /'
            failed=$((failed + 1))
        fi
        rm "$out/tests/$name.status"
    done
}

out=out/gpu
previous=
for argument in "$@"; do
    case $argument in
        -h | --help | -\? | --usage | -V | --version) exec "$bench" gpu "$argument" ;;
        --out=*) out=${argument#--out=} ;;
        *) [ "$previous" != --out ] || out=$argument ;;
    esac
    previous=$argument
done

[ ! -d "$here/gl" ] || use_own_loaders
# The last option counts: the device, and no scene.
status=0
device=$("$bench" gpu "$@" --triangles 0) || status=$?
[ "$status" -ne 4 ] || show_drivers >&2
[ "$status" -eq 0 ] || exit "$status"
kind=$(echo "$device" | sed -n 's/^device: \([a-z]*\).*/\1/p')
echo "$device"
echo
run_tests "$kind"
echo
"$bench" gpu "$@" || status=$?
if [ "$failed" -ne 0 ]; then
    echo "$failed tests FAILED on $kind" >&2
    [ "$status" -ne 0 ] || status=1
fi
exit "$status"
