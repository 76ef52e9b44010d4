#!/bin/sh
# demos/bench/gpu/run.sh over a folder as demos/gpu.sh lays it out, with few programs: device, tests, benchmark; and failures.
# test_gpu_run.sh SOURCE_FOLDER QC_BENCH TEST_PROGRAM
set -eu

source=$1
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
mkdir "$folder/bin" "$folder/work"
# Programs of a build folder find their libraries by absolute paths.
cp "$2" "$folder/bin/qc-bench"
cp "$3" "$folder/bin/test_first"
cp "$source/demos/bench/gpu/run.sh" "$folder/run.sh"
cd "$folder/work"

# expect STATUS COMMAND...: output and messages go to $folder/log.
expect()
{
    expected=$1
    shift
    status=0
    "$@" >"$folder/log" 2>&1 || status=$?
    [ "$status" -eq "$expected" ] && return
    cat "$folder/log"
    echo "exit status $status instead of $expected: $*"
    exit 1
}

contains()
{
    grep -q -- "$1" "$folder/log" && return
    cat "$folder/log"
    echo "the output lacks: $1"
    exit 1
}

if ! "$folder/bin/qc-bench" gpu --triangles 0; then
    echo "Skipped: no GL device"
    exit 0
fi

expect 0 sh "$folder/run.sh" --triangles 1000 --scenes cloth
contains '^device: '
contains 'test_first: ok'
contains ' equal$'
for file in gpu.csv gpu_stages.csv gpu.txt tests/test_first.txt; do
    [ -s "out/gpu/$file" ] || { echo "out/gpu/$file is missing"; exit 1; }
done

# The place of all files is the option's.
expect 0 sh "$folder/run.sh" --out there --triangles 0
[ -s there/tests/test_first.txt ] || { echo 'the log of the test is missing'; exit 1; }

# A test that fails is named, and the benchmark still runs.
# shellcheck disable=SC2016 # The script expands it.
printf '#!/bin/sh\necho "$QC_TEST_DEVICES: broken"\nexit 1\n' >"$folder/bin/test_second"
chmod +x "$folder/bin/test_second"
expect 1 sh "$folder/run.sh" --triangles 1000 --scenes cloth
contains 'test_second: FAILED'
contains '^    [a-z]*: broken'
contains '^1 tests FAILED'
contains ' equal$'

expect 4 env __EGL_VENDOR_LIBRARY_DIRS=/nowhere sh "$folder/run.sh" --device surfaceless
contains '^qc-bench gpu: device surfaceless: '
contains '^EGL drivers: '
expect 2 sh "$folder/run.sh" --scenes clot
contains "'clot' is not one of"
expect 0 sh "$folder/run.sh" --help
expect 0 sh "$source/demos/gpu.sh" --help
contains 'Usage: demos/gpu.sh'
# Before anything is built.
expect 2 sh "$source/demos/gpu.sh" --scenes cloth --treads 2
contains "unrecognized option '--treads'"
expect 2 sh "$source/demos/gpu.sh" --bundle
expect 2 sh "$source/demos/gpu.sh" --bundle file.zip
contains "'file.zip' is no name of a .tar.gz"
expect 1 sh "$source/demos/gpu.sh" --bundle nowhere/file.tar.gz
contains "can't be written"
