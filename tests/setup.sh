# Sourced by tests/run.sh, demos/run.sh and demos/gpu.sh: the packages that each needs, named here only, and the build.
# shellcheck shell=sh

# qc_packages GROUP...: the packages of the groups.
qc_packages()
{
    for group in "$@"; do
        case $group in
            build) echo build-essential cmake pkg-config libepoxy-dev libbullet-dev libpng-dev libjson-c-dev \
                voro++-dev libglu1-mesa-dev ;;
            tests) echo check libgmp-dev libbullet-extras-dev glmark2-data libxml2-utils ;;
            demos) echo ffmpeg ;;
            models) echo glmark2-data ;;
            bench) echo gnuplot-nox glmark2-data ;;
            # Built into modules for "qc-bench peers", and nothing else.
            peers) echo libembree-dev libcgal-dev libtbb-dev ;;
            # Software GL, opened at run time: a system that no longer has one of them does without. With Vulkan's
            # software driver the tests run on a second GL, zink.
            optional) echo libosmesa6 libegl1 libgl1-mesa-dri mesa-vulkan-drivers ;;
            # For demos/gpu.sh to pack, where another machine has a GPU's driver alone.
            loaders) echo libegl1 libopengl0 ;;
            # A client of libBulletCollision, to be run with qc-preload; without it that test is skipped.
            clients) echo libdart-dev libdart-collision-bullet-dev ;;
            # For tests/machines/run.sh: other compilers and processors.
            machines) echo clang gcc-i686-linux-gnu gcc-aarch64-linux-gnu gcc-s390x-linux-gnu libc6-dev-i386-cross \
                libc6-dev-arm64-cross libc6-dev-s390x-cross qemu-user-static ;;
            # To look at the report's page; without it that test is skipped. 100 MB: qc_wishes=browser tests/run.sh
            browser) echo chromium ;;
            # The live window of the demos, --view, and a display for its test; without them the demos have no window.
            view) echo libglfw3-dev libimgui-dev fonts-dejavu-core ;;
            display) echo xvfb xauth ;;
            # tests/run.sh --sanitize memory, tests/fuzz/run.sh
            clang) echo clang llvm libclang-rt-dev ;;
            # tests/lint.sh
            lint) echo clang-format clang-tidy cppcheck shellcheck ;;
            # tests/coverage.sh
            coverage) echo gcovr ;;
            # For the target docs and its test; without it that test is skipped.
            docs) echo doxygen ;;
        esac
    done
}

qc_missing()
{
    for package in "$@"; do
        if ! dpkg-query -W -f '${Status}\n' "$package" 2>/dev/null | grep -q '^install ok installed$'; then
            printf ' %s' "$package"
        fi
    done
}

# The GL devices whose packages are installed, as QC_TEST_DEVICES names them.
qc_gl_devices()
{
    devices=
    if command -v dpkg-query >/dev/null; then
        [ -n "$(qc_missing libosmesa6)" ] || devices=osmesa
        [ -n "$(qc_missing libegl1 libgl1-mesa-dri)" ] || devices=$devices,surfaceless
        [ -n "$(qc_missing libegl1 libgl1-mesa-dri mesa-vulkan-drivers)" ] || devices=$devices,zink
    fi
    echo "${devices#,}"
}

qc_known()
{
    for package in "$@"; do
        if apt-cache show "$package" >/dev/null 2>&1; then
            printf ' %s' "$package"
        fi
    done
}

# qc_install GROUP...: installs what is missing of the groups, and, as far as the system knows them, of the optional
# packages and of the groups that $qc_wishes names.
# shellcheck disable=SC2046,SC2086 # Package lists are words.
qc_install()
{
    set -- $(qc_packages "$@")
    if ! command -v apt-get >/dev/null || ! command -v dpkg-query >/dev/null; then
        echo "Neither Debian nor Ubuntu. What these packages hold must be here: $*" >&2
        return 0
    fi
    needed=$(qc_missing "$@")
    optional=$(qc_known $(qc_missing $(qc_packages optional ${qc_wishes-})))
    if [ -z "$needed$optional" ]; then
        return 0
    fi
    if [ "$(id -u)" -eq 0 ]; then
        as_root=
    elif sudo -n true 2>/dev/null; then
        as_root='sudo -n'
    else
        echo "Packages are missing. As root: apt-get update && apt-get install -y$needed$optional" >&2
        [ -z "$needed" ] || exit 1
        return 0
    fi
    echo "Installing$needed$optional"
    $as_root apt-get update -q || echo "apt-get update failed: going on with the old package lists" >&2
    # A fresh machine knows them only now.
    optional=$(qc_known $(qc_missing $(qc_packages optional ${qc_wishes-})))
    $as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -q --no-install-recommends $needed $optional
}

# qc_build ROOT TARGET [CMAKE_OPTION...]: configures and builds in $qc_folder, by default ROOT/build.
qc_build()
{
    root=$1
    target=$2
    shift 2
    # A build folder keeps the generator that it was made with.
    folder=${qc_folder-$root/build}
    if [ ! -f "$folder/CMakeCache.txt" ] && command -v ninja >/dev/null; then
        set -- -G Ninja "$@"
    fi
    cmake -S "$root" -B "$folder" -DCMAKE_BUILD_TYPE=Release "$@"
    cmake --build "$folder" --parallel "$(nproc)" --target "$target"
}
