#!/bin/sh
# What is installed can be used from outside, through CMake and through pkg-config, and brings no GL along. A project
# can embed the source.
# test_packaging.sh BUILD_FOLDER SOURCE_FOLDER LIBRARY_FOLDER CC CXX [bullet] [bullet_double] [fracture] ...
set -eu

build=$1
source=$2
libraries=$3
CC=$4
CXX=$5
shift 5
export CC CXX

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
prefix=$work/prefix
lib=$prefix/$libraries

fail()
{
    echo "$*" >&2
    exit 1
}

echo "== install"
cmake --install "$build" --prefix "$work/first" >"$work/log" || fail "$(cat "$work/log")"
# The package may be moved as a whole.
mv "$work/first" "$prefix"

echo "== each header alone"
# parse_with PACKAGE FILE: Bullet's own headers are not held to our warnings.
parse_with()
{
    # shellcheck disable=SC2046 # Flags are words.
    "$CXX" -std=c++11 -pedantic-errors -Wall -Wextra -Werror -I"$prefix/include" \
        $(pkg-config --cflags "$1" | sed 's/-I/-isystem /g') -fsyntax-only "$2"
}
# Headers depend on the precision of Bullet, not on the component.
alone=
together=
for component in "$@"; do
    case $component in
        bullet | fracture) package=bullet ;;
        *) package=bullet-float64 ;;
    esac
    if [ -z "$alone" ]; then
        alone=$package
    elif [ "$package" != "$alone" ]; then
        together=$package
    fi
done
for header in "$prefix"/include/quickcullide/*.h; do
    name=${header##*/}
    printf '#include <quickcullide/%s>\n' "$name" >"$work/header.c"
    cp "$work/header.c" "$work/header.cpp"
    case $name in
        bullet*) ;;
        *)
            "$CC" -std=c99 -pedantic-errors -Wall -Wextra -Werror -I"$prefix/include" -fsyntax-only "$work/header.c"
            "$CXX" -std=c++11 -pedantic-errors -Wall -Wextra -Werror -I"$prefix/include" -fsyntax-only \
                "$work/header.cpp"
            ;;
    esac
    # Which headers a header includes depends on no precision: alone with the first, all together with the other.
    [ -z "$alone" ] || parse_with "$alone" "$work/header.cpp"
    cat "$work/header.cpp" >>"$work/headers.cpp"
done
[ -z "$together" ] || parse_with "$together" "$work/headers.cpp"

echo "== what the library needs and shows"
if [ -f "$lib/libquickcullide.so" ]; then
    readelf -d "$lib/libquickcullide.so" >"$work/dynamic"
    grep -q NEEDED "$work/dynamic"
    if grep NEEDED "$work/dynamic" | grep -iE 'GL|OSMesa|epoxy|Bullet|LinearMath|stdc\+\+'; then
        fail "libquickcullide links what a user may not have"
    fi
    nm -D --defined-only "$lib/libquickcullide.so" | awk '{ print $3 }' >"$work/symbols"
    grep -q '^qcScene_Detect$' "$work/symbols"
    if grep -v '^qc' "$work/symbols"; then
        fail "libquickcullide shows symbols that are not its own"
    fi
fi

echo "== the installed tool runs"
if [ -f "$prefix/bin/qc-pairs" ]; then
    "$prefix/bin/qc-pairs" --help >/dev/null
    "$prefix/bin/qc-replay" --help >/dev/null
fi

echo "== the licence, the manual and its programs"
manual=$prefix/share/doc/quickcullide
cmp "$source/LICENSE" "$manual/LICENSE"
for file in README.md plugin/docs/bullet.md plugin/docs/proofs/preload.md demos/cloth/cloth.png; do
    cmp "$source/$file" "$manual/$file"
done
sh "$source/tests/house/test_links.sh" "$manual"
"$CC" "$manual/demos/hello/core.c" -I"$prefix/include" -fsyntax-only
for program in "$manual"/demos/hello/*.cpp; do
    # shellcheck disable=SC2046 # Flags are words.
    [ -z "$alone" ] || "$CXX" -std=c++14 "$program" -I"$prefix/include" $(pkg-config --cflags "$alone") -fsyntax-only
done

echo "== inside another project"
cmake -S "$source/tests/house/embedding" -B "$work/embedding" -DQC_SOURCE="$source" >"$work/log" 2>&1 ||
    fail "$(cat "$work/log")"

echo "== through CMake"
components=$(printf '%s;' "$@")
cmake -S "$source/tests/house/installed" -B "$work/cmake" -DCMAKE_PREFIX_PATH="$prefix" -DCMAKE_BUILD_TYPE=Release \
    -DQC_COMPONENTS="${components%;}" >"$work/log" || fail "$(cat "$work/log")"
cmake --build "$work/cmake" >"$work/log" 2>&1 || fail "$(cat "$work/log")"
ctest --test-dir "$work/cmake" --output-on-failure

echo "== through pkg-config"
export PKG_CONFIG_PATH="$lib/pkgconfig"
export LD_LIBRARY_PATH="$lib"
use()
{
    program=$1
    compiler=$2
    package=$3
    # shellcheck disable=SC2046 # Flags are words.
    "$compiler" "$source/tests/house/installed/$program" -o "$work/program" $(pkg-config $static --cflags --libs "$package")
    "$work/program"
}
# Without the shared library the private libraries are needed too.
static=
[ -f "$lib/libquickcullide.so" ] || static=--static
use core.c "$CC" quickcullide
for component in "$@"; do
    case $component in
        bullet*) use bullet.cpp "$CXX" "quickcullide_$component" ;;
        fracture*) use fracture.cpp "$CXX" "quickcullide_$component" ;;
    esac
done
