#!/bin/sh
# Installs what is missing (Debian, Ubuntu), builds into build/, runs a demo. demos/run.sh --help lists them.
set -eu

show_help()
{
    cat <<'END'
Usage: demos/run.sh [DEMO] [ARGUMENT...]

Demos:
  cloth     A cloth falls over a table, folds and meets itself, and is pulled away (the default). Pictures, and a film
            where ffmpeg is installed, go to out/cloth/.
  fracture  A bunny falls and breaks in the midst of a step, and its pieces come to rest. Pictures, and a film,
            go to out/fracture/.
  leaves    Leaves fall from a tree, collide with each other, its branches and the ground. Pictures, and a film, go to
            out/leaves/.
  through   Bodies thrown at each other so fast that they could pass: a table of penetrating pairs inside each step, beside
            version 0.2.0, and pictures of a thrown cloth, and a film, in out/through/. About ten minutes; --quick: one.
  pairs     Finds the triangles of meshes that intersect: demos/run.sh pairs MESH...
  bench     Measures: demos/run.sh bench [accuracy] compares the methods, "bench peers" other libraries
            (which it installs), "bench scaling" sizes, "bench broadphase" the broadphase with Bullet's own, "bench soft"
            cloth, tangles and ropes with Bullet's, "bench paper" the paper's scenes, tables and figures (on recordings
            of the demos, made first where they are missing), "bench gpu" layers on a GL device with sweep. Tables and pictures
            go to out/bench/. demos/gpu.sh runs the GL tests first, and packs all that for a machine with a GPU.
  gallery   Makes the README's pictures from the frames in out/.

With --view, cloth, fracture, breaking and leaves open a live window in place of files.

Arguments are the demo's own; "demos/run.sh DEMO --help" explains them.
END
}

# clear_film NAME: frames of a longer run before would end up in the film.
clear_film()
{
    mkdir -p "$root/out/$1"
    rm -f "$root/out/$1"/frame_*.png "$root/out/$1/$1.mp4"
}

# make_film NAME FRAMES_A_SECOND: from the frames in out/NAME.
make_film()
{
    out=$root/out/$1
    if [ -f "$out/frame_0000.png" ] && command -v ffmpeg >/dev/null; then
        ffmpeg -loglevel error -y -framerate "$2" -i "$out/frame_%04d.png" -c:v libx264 -pix_fmt yuv420p \
            -vf 'pad=ceil(iw/2)*2:ceil(ih/2)*2' "$out/$1.mp4"
        echo "The film is $out/$1.mp4"
    fi
}

# run_filmed NAME FRAMES_A_SECOND [ARGUMENT...]: a demo that draws, and a film of its frames.
run_filmed()
{
    name=$1
    rate=$2
    shift 2
    clear_film "$name"
    # Ctrl-C ends the demo, not this script: what was drawn becomes a film.
    trap : INT
    status=0
    "$root/build/demos/qc-$name" --out "$root/out/$name" "$@" || status=$?
    trap - INT
    make_film "$name" "$rate"
    return "$status"
}

run_through()
{
    clear_film through
    trap : INT
    status=0
    "$root/build/demos/qc-bench" through --frames "$root/out/through" --csv "$root/out/through/through.csv" "$@" ||
        status=$?
    trap - INT
    # Four pictures a step.
    make_film through 12
    return "$status"
}

run_bench()
{
    bench=$root/build/demos/qc-bench
    case ${1-} in
        -h | --help) "$bench" --help ;;
        '' | -*) run_benchmark accuracy "$@" ;;
        paper)
            for scene in cloth breaking leaves; do
                make_recording "$scene"
            done
            run_benchmark "$@"
            ;;
        *) run_benchmark "$@" ;;
    esac
}

# make_recording DEMO: its recording for "bench paper", if it is missing. No device: all methods give the same run.
make_recording()
{
    folder=$root/out/recordings
    if [ -f "$folder/$1.qcr" ]; then
        return 0
    fi
    qc_build "$root" "qc-$1" >/dev/null || return 0
    echo "Recording the demo $1"
    mkdir -p "$folder/new"
    "$root/build/demos/qc-$1" --device none --method sweep --out "$folder/new" --record "$folder/new/$1.qcr" >/dev/null
    mv "$folder/new"/*.qcr "$folder/"
    rm -r "$folder/new"
}

# run_benchmark NAME [ARGUMENT...]
run_benchmark()
{
    name=$1
    shift
    if [ "$name" = paper ]; then
        set -- --recordings "$root/out/recordings" "$@"
    fi
    # tests/dragon.sh leaves it there.
    dragon=$root/build/models/dragon_vrip.ply
    if [ -f "$dragon" ]; then
        case $name in
            accuracy | peers) set -- --dragon "$dragon" "$@" ;;
        esac
    fi
    "$bench" "$name" --out "$root/out/bench" "$@"
}

demo=cloth
case ${1-} in
    -h | --help)
        show_help
        exit 0
        ;;
    gallery) exec "$(dirname -- "$0")/gallery.sh" ;;
    cloth | fracture | leaves | through | pairs | bench)
        demo=$1
        shift
        ;;
    '' | -*) ;;
    *)
        echo "demos/run.sh: there is no demo '$1'; try --help" >&2
        exit 2
        ;;
esac

root=$(CDPATH='' cd -- "$(dirname -- "$0")/.." && pwd)
# shellcheck source=/dev/null
. "$root/tests/setup.sh"

# shellcheck disable=SC2034 # Read by qc_install.
case " $* " in
    *' --view '*) qc_wishes=view ;;
esac
case $demo in
    cloth | leaves) qc_install build demos ;;
    fracture | through) qc_install build demos models ;;
    bench)
        case ${1-} in
            peers) qc_install build bench peers ;;
            paper) qc_install build bench peers models ;;
            *) qc_install build bench ;;
        esac
        ;;
    *) qc_install build ;;
esac
program=qc-$demo
if [ "$demo" = through ]; then
    program=qc-bench
fi
# The tests need more packages: they are built where tests/run.sh has been.
if [ -f "$root/build/CMakeCache.txt" ]; then
    qc_build "$root" "$program"
else
    qc_build "$root" "$program" -DQC_BUILD_TESTS=OFF
fi
# A live window has no frames and no film.
case " $* " in
    *' --view '*) exec "$root/build/demos/$program" --out "$root/out/$demo" "$@" ;;
esac
case $demo in
    # 120 steps a second, a frame every 10; 600 steps.
    cloth) run_filmed cloth 12 "$@" ;;
    fracture) run_filmed fracture 24 "$@" ;;
    # 120 steps a second, a frame every 10.
    leaves) run_filmed leaves 12 "$@" ;;
    through) run_through "$@" ;;
    pairs) "$root/build/demos/qc-pairs" "$@" ;;
    bench) run_bench "$@" ;;
esac
