#!/bin/sh
# The method layers on this machine's GPU: device, tests, benchmark. Or a bundle of all that for another machine.
set -eu

show_help()
{
    cat <<'END'
Usage: demos/gpu.sh [OPTION...]
       demos/gpu.sh --bundle FILE.tar.gz

Shows which GL device and driver this machine has, runs the tests on it, and measures layers beside sweep, each kernel
by the device's clock: tables and CSV go to out/gpu/, the tests' output to out/gpu/tests/. Options are those of
"qc-bench gpu" (--device, --gpu, --scenes, --triangles, --threads, --dragon, --recordings, --out);
"demos/gpu.sh --list-options" explains them. The dragon and the paper's scenes are measured where "demos/run.sh bench
paper" has left them.
Packages that are missing are installed where apt and a network are there. The build folder is build-gpu/.

  --bundle  Packs the programs, GL's loaders and a script into FILE.tar.gz, for a machine with a GPU driver and without
            compiler or network. There: tar xzf FILE.tar.gz && quickcullide-gpu/run.sh

Software GL is no GPU, and named loudly. Mesa's second GL, as a rehearsal without a GPU:
    LIBGL_ALWAYS_SOFTWARE=1 MESA_LOADER_DRIVER_OVERRIDE=zink GALLIUM_DRIVER=zink QC_LAYERS_REFINE=device \
        demos/gpu.sh --device surfaceless
END
}

fail()
{
    echo "demos/gpu.sh: $1" >&2
    exit "${2-1}"
}

root=$(CDPATH='' cd -- "$(dirname -- "$0")/.." && pwd)

# check_options [ARGUMENT...]: refuses an unknown option before minutes of building. The names are those of the table of
# "qc-bench gpu", whose rows begin with a group and a name; values are checked by the program.
check_options()
{
    names=$(sed -n 's/^ *{[0-9], "\([a-z-]*\)".*/\1/p' "$root/demos/bench/gpu/options.c" | tr '\n' ' ')
    for argument in "$@"; do
        name=${argument%%=*}
        case $name in
            --help | --usage) ;;
            --?*)
                # A beginning of a name is enough.
                case " $names" in
                    *" ${name#--}"*) ;;
                    *) fail "unrecognized option '$name'; \"demos/gpu.sh --list-options\" lists them" 2 ;;
                esac
                ;;
        esac
    done
}

bundle=
case ${1-} in
    -h | --help)
        show_help
        exit 0
        ;;
    --bundle | --bundle=*)
        if [ "$1" = --bundle ]; then
            [ $# -eq 2 ] || fail '--bundle takes one FILE.tar.gz and no other option' 2
            bundle=$2
        else
            [ $# -eq 1 ] || fail '--bundle takes one FILE.tar.gz and no other option' 2
            bundle=${1#--bundle=}
        fi
        case $bundle in
            ?*.tar.gz | ?*.tgz) ;;
            *) fail "--bundle: '$bundle' is no name of a .tar.gz" 2 ;;
        esac
        # Better now than after minutes of work.
        touch "$bundle.part" 2>/dev/null || fail "--bundle: '$bundle' can't be written"
        rm "$bundle.part"
        ;;
    --list-options) set -- --help ;;
esac
[ -n "$bundle" ] || check_options "$@"

# shellcheck source=/dev/null
. "$root/tests/setup.sh"
qc_folder=$root/build-gpu
stage=$qc_folder/quickcullide-gpu

install_packages()
{
    # shellcheck disable=SC2034 # Read by qc_install.
    qc_wishes=loaders
    if ! (qc_install build tests); then
        echo 'Packages could not be installed: going on with what is here' >&2
    fi
    for tool in cc c++ cmake pkg-config; do
        command -v "$tool" >/dev/null ||
            fail "there is no $tool here: pack a bundle on another machine, demos/gpu.sh --bundle FILE.tar.gz"
    done
}

# find_library NAME: its file. Libraries of this processor's own kind stand first.
find_library()
{
    PATH=$PATH:/sbin:/usr/sbin ldconfig -p | sed -n "s/^[[:space:]]*$1 (libc6[^)]*) => //p" | sed -n 1p
}

# copy_library FILE FOLDER: with the licence of its package.
copy_library()
{
    cp -L "$1" "$2"
    command -v dpkg-query >/dev/null || return 0
    for file in "$1" "$(readlink -f "$1")"; do
        package=$(dpkg-query -S "$file" 2>/dev/null | sed -n '1s/:.*//p')
        [ -z "$package" ] || cp "/usr/share/doc/$package/copyright" "$stage/licences/$package.txt"
    done
}

# The programs, the libraries that they need beside the C library, GL's loaders, the script.
lay_out()
{
    rm -rf "$stage"
    mkdir -p "$stage/bin" "$stage/lib" "$stage/gl/egl_vendor.d" "$stage/licences"
    cp "$root/LICENSE" "$stage/licences/quickcullide.txt"
    while read -r program; do
        cp "$program" "$stage/bin"
    done <"$qc_folder/gpu_programs.txt"
    ldd "$stage"/bin/* | sed -n 's/.* => \(\/[^ ]*\).*/\1/p' | sort -u |
        grep -vE '/(libc|libm|libdl|librt|libpthread)\.so\.[0-9]+$' | while read -r library; do
            copy_library "$library" "$stage/lib"
        done
    for name in libEGL.so.1 libGLdispatch.so.0 libOpenGL.so.0; do
        library=$(find_library "$name")
        [ -z "$library" ] || copy_library "$library" "$stage/gl"
    done
    echo '{"file_format_version": "1.0.0", "ICD": {"library_path": "libEGL_nvidia.so.0"}}' \
        >"$stage/gl/egl_vendor.d/10_nvidia.json"
    cp "$root/demos/bench/gpu/run.sh" "$stage/run.sh"
    chmod +x "$stage/run.sh"
}

pack()
{
    [ -e "$stage/gl/libEGL.so.1" ] || echo 'There is no libEGL here to be packed: the other machine must have it' >&2
    tar -C "$qc_folder" -czf "$bundle.part" quickcullide-gpu
    mv "$bundle.part" "$bundle"
    libc=$(objdump -T "$stage"/bin/* "$stage"/lib/* | grep -o 'GLIBC_[0-9.]*' | sort -uV | sed -n '$s/GLIBC_//p')
    echo "$bundle: for Linux on $(uname -m) with glibc $libc or later and a GPU's driver. There:"
    echo "    tar xzf $(basename -- "$bundle") && quickcullide-gpu/run.sh"
}

install_packages
# For any processor of the kind, and without the peers' libraries.
qc_build "$root" qc-gpu -DBUILD_SHARED_LIBS=OFF -DQC_BUILD_BULLET=OFF -DQC_BUILD_TESTS=ON -DQC_BUILD_DEMOS=ON \
    -DCMAKE_DISABLE_FIND_PACKAGE_OpenMP=ON -DCMAKE_DISABLE_FIND_PACKAGE_TBB=ON \
    -DCMAKE_DISABLE_FIND_PACKAGE_embree=ON -DCMAKE_DISABLE_FIND_PACKAGE_CGAL=ON \
    -DCMAKE_EXE_LINKER_FLAGS=-Wl,--as-needed "-DCMAKE_BUILD_RPATH=\$ORIGIN/../lib"
lay_out
if [ -n "$bundle" ]; then
    pack
else
    # demos/run.sh and tests/dragon.sh leave these there; without them their rows are skipped.
    dragon=$root/build/models/dragon_vrip.ply
    [ ! -f "$dragon" ] || set -- --dragon "$dragon" "$@"
    exec "$stage/run.sh" --out "$root/out/gpu" --recordings "$root/out/recordings" "$@"
fi
