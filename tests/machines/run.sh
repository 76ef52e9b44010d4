#!/bin/sh
# Builds the library with other compilers, options and processors, runs the programs of golden hashes and compares what
# they print with the golden files of tests/house/golden. One line of the table for each row and choice of kernels.
#     tests/machines/run.sh [--install] [ROW...]    the rows named, by default all whose compiler is here
#     tests/machines/run.sh --list                  the rows and what they are built with
# --install: installs the compilers and emulators (Debian, Ubuntu) first. Builds and what the programs printed lie in
# build/machines. Columns: digests of all lines of a kind; world: of Bullet's worlds, float and double. An emulated row
# runs the first scenes only.
set -eu

root=$(CDPATH='' cd -- "$(dirname -- "$0")/../.." && pwd)
# shellcheck source=/dev/null
. "$root/tests/setup.sh"
golden=$root/tests/house/golden
work=${qc_folder-$root/build}/machines

# Name, processor, C compiler, C++ compiler (-: no Bullet), options, emulator (-: none), choices of QC_KERNELS. The
# kernels "refused": the configuration must fail.
rows()
{
    cat <<'EOF'
O0 x86-64 gcc g++ -O0 - plain,avx2,avx512
O3 x86-64 gcc g++ -O3 - plain,avx2,avx512
clang x86-64 clang clang++ -O3 - plain,avx2,avx512
x86-64 x86-64 gcc - -O2,-march=x86-64 - plain,avx512
native x86-64 gcc - -O2,-march=native - plain,avx512
mavx2 x86-64 gcc - -O2,-mavx2,-mfma - plain,avx512
mavx512 x86-64 gcc - -O2,-mavx512f,-mavx512bw,-mavx512vl,-mfma - plain,avx512
clang-native x86-64 clang - -O2,-march=native - plain,avx512
i686 i686 i686-linux-gnu-gcc - -O2,-msse2,-mfpmath=sse - plain
x87 i686 i686-linux-gnu-gcc - -O2 - refused
arm64 aarch64 aarch64-linux-gnu-gcc - -O2 qemu-aarch64-static plain
s390x s390x s390x-linux-gnu-gcc - -O2 qemu-s390x-static plain
EOF
}

# digest WORD FILE: of the parts of the lines of a file that match, in their order.
digest()
{
    awk -v parts="$1" '!/^#/ && $1 !~ /:work$/ {
        for (i = 2; i <= NF; ++i)
            if ($i ~ "^(" parts ")=")
                print $1, $i
    }' "$2" | sha256sum | cut -c 1-8
}

# print_row NAME PROCESSOR COMPILER OPTIONS KERNELS HASHES WORLDS EQUAL
print_row()
{
    world=-
    if [ -s "$7" ]; then
        world=$(sha256sum <"$7" | cut -c 1-8)
    fi
    printf '%-13s %-8s %-22s %-44s %-7s %-9s %-9s %-9s %-9s %-9s %s\n' "$1" "$2" "$3" "$4" "$5" \
        "$(digest 'pairs|relations' "$6")" "$(digest 'contacts|proximities|segments' "$6")" \
        "$(digest 'manifolds|points' "$6")" "$(digest 'moved|began|ended|bounds|box|begun|cast' "$6")" "$world" "$8"
}

# without_work FILE: the lines that don't depend on the instructions of the kernels.
without_work()
{
    grep -v -e '^#' -e '^[^ ]*:work ' "$1"
}

# configure FOLDER PROCESSOR CC CXX OPTIONS. The library takes types alone from epoxy: this machine's headers serve all.
configure()
{
    folder=$1
    mkdir -p "$folder/include"
    ln -sfn /usr/include/epoxy /usr/include/EGL /usr/include/KHR "$folder/include/"
    printf 'Name: epoxy\nDescription: headers\nVersion: 1.5\nCflags: -I%s\n' "$folder/include" >"$folder/epoxy.pc"
    flags=$(echo "$5" | tr , ' ')
    set -- "$folder" "$2" "$3" "$4" "$flags" "-DCMAKE_C_COMPILER=$3" "-DCMAKE_C_FLAGS=$flags"
    bullet=OFF
    if [ "$4" != - ]; then
        bullet=ON
    fi
    (
        if [ "$2" != x86-64 ]; then
            set -- "$@" -DCMAKE_SYSTEM_NAME=Linux "-DCMAKE_SYSTEM_PROCESSOR=$2" -DCMAKE_EXE_LINKER_FLAGS=-static
            PKG_CONFIG_LIBDIR=$folder
            export PKG_CONFIG_LIBDIR
        elif [ "$bullet" = ON ]; then
            set -- "$@" "-DCMAKE_CXX_COMPILER=$4" "-DCMAKE_CXX_FLAGS=$flags"
        fi
        shift 5
        cmake -S "$root/tests/machines" -B "$folder" -DCMAKE_BUILD_TYPE=None -DBUILD_SHARED_LIBS=OFF \
            "-DQC_BUILD_BULLET=$bullet" "$@"
    )
}

# run_kernels NAME PROCESSOR CC CXX OPTIONS EMULATOR KERNELS: runs the programs of a build.
run_kernels()
{
    out=$work/$1.$7
    emulator=$6
    [ "$emulator" != - ] || emulator=/usr/bin/env
    equal=yes
    golden_hashes=$work/golden.hashes
    if [ "$6" = - ]; then
        QC_KERNELS=$7 "$emulator" "$work/$1/core_hashes" >"$out.txt" || equal='NO (core_hashes failed)'
        without_work "$out.txt" >"$out.hashes" || true
    else
        # Minutes as it is: the scenes before `many`.
        equal='yes (first scenes)'
        "$emulator" "$work/$1/core_hashes" 2>"$out.err" | sed '/^many\//Q' >"$out.txt"
        without_work "$out.txt" >"$out.hashes" || true
        golden_hashes=$out.golden
        sed '/^many\//,$d' "$work/golden.hashes" >"$golden_hashes"
    fi
    : >"$out.worlds"
    if [ "$4" != - ]; then
        for precision in single double; do
            program=$work/$1/bullet_hashes_$precision
            [ ! -x "$program" ] || QC_KERNELS=$7 "$program" >>"$out.worlds" || equal="NO ($program failed)"
        done
        # The first line of each names Bullet and the C library for which the golden worlds hold.
        if [ "$(grep '^#' "$out.worlds")" = "$(grep '^#' "$work/golden.worlds")" ]; then
            cmp -s "$out.worlds" "$work/golden.worlds" || equal='NO (world)'
        elif [ "$equal" = yes ]; then
            equal='yes (no golden world for this Bullet)'
        fi
    fi
    cmp -s "$out.hashes" "$golden_hashes" || equal=NO
    print_row "$1" "$2" "$3" "$5" "$7" "$out.hashes" "$out.worlds" "$equal"
    case $equal in
        NO*) failed="$failed $1.$7" ;;
    esac
}

# run_row NAME PROCESSOR CC CXX OPTIONS EMULATOR KERNELS
run_row()
{
    for program in "$3" "$(echo "$4" | sed 's/^-$/sh/')" "$(echo "$6" | sed 's/^-$/sh/')"; do
        if ! command -v "$program" >/dev/null; then
            echo "$1: left out, no $program here (tests/machines/run.sh --install)"
            [ -z "$named" ] || failed="$failed $1"
            return 0
        fi
    done
    log=$work/$1.log
    mkdir -p "$work/$1"
    configured=yes
    configure "$work/$1" "$2" "$3" "$4" "$5" >"$log" 2>&1 || configured=no
    if [ "$7" = refused ]; then
        if [ $configured = no ] && grep -q 'in wider registers' "$log"; then
            printf '%-13s %-8s %-22s %-44s refused when it is configured, as it must be\n' "$1" "$2" "$3" "$5"
        else
            echo "$1: not refused"
            failed="$failed $1"
        fi
        return 0
    fi
    if [ $configured = no ] || ! cmake --build "$work/$1" --parallel "$(nproc)" >>"$log" 2>&1; then
        echo "$1: does not build: $log"
        failed="$failed $1"
        return 0
    fi
    for kernels in $(echo "$7" | tr , ' '); do
        # What this processor has not would be replaced in silence.
        if [ "$kernels" != plain ] && ! grep -q "$(echo "$kernels" | sed s/avx512/avx512f/)" /proc/cpuinfo; then
            echo "$1: left out, no $kernels here"
        else
            run_kernels "$1" "$2" "$3" "$4" "$5" "$6" "$kernels"
        fi
    done
}

named=
failed=
while [ $# -gt 0 ]; do
    case $1 in
        -h | --help)
            sed -n '2,/^set/s/^# \{0,1\}//p' "$0"
            exit 0
            ;;
        --list)
            rows
            exit 0
            ;;
        --install) qc_install build machines ;;
        *)
            if ! rows | grep -q "^$1 "; then
                echo "No row $1; --list prints them" >&2
                exit 2
            fi
            named="$named $1"
            ;;
    esac
    shift
done

mkdir -p "$work"
without_work "$golden/core_hashes.txt" >"$work/golden.hashes"
cat "$golden/bullet_hashes_single.txt" "$golden/bullet_hashes_double.txt" >"$work/golden.worlds"
printf '%-13s %-8s %-22s %-44s %-7s %-9s %-9s %-9s %-9s %-9s %s\n' row platform compiler options kernels pairs contacts \
    manifolds boxes world equal
print_row golden - - - - "$work/golden.hashes" "$work/golden.worlds" -
rows >"$work/rows"
while read -r name processor cc cxx options emulator kernels <&3; do
    case " ${named:-$name} " in
        *" $name "*) run_row "$name" "$processor" "$cc" "$cxx" "$options" "$emulator" "$kernels" ;;
    esac
done 3<"$work/rows"
if [ -n "$failed" ]; then
    echo "Not equal, or not there:$failed. What they printed: $work/ROW.KERNELS.txt" >&2
    exit 1
fi
