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
  breaking  A bunny falls on a dragon again and again, and breaks it piece by piece. The dragon is fetched with npm;
            without it a knot stands in. Pictures, and a film, go to out/breaking/.
  leaves    Leaves fall from a tree, collide with each other, its branches and the ground. Pictures, and a film, go to
            out/leaves/.
  through   Bodies thrown at each other so fast that they could pass: a table of penetrating pairs inside each step, beside
            version 0.2.0, and pictures of a thrown cloth, and a film, in out/through/. About ten minutes; --quick: one.
  gl-cloth  A cloth in GL buffers on the GPU; its self-collisions are found there, and no vertex is uploaded. A table.
  pairs     Finds the triangles of meshes that intersect: demos/run.sh pairs MESH...
  bench     Measures: demos/run.sh bench [accuracy] compares the methods, "bench peers" other libraries (which it
            installs), "bench first" the first steps of new meshes, "bench scaling" sizes, "bench broadphase" the
            broadphase with Bullet's own, "bench soft" cloth, tangles and ropes with Bullet's, "bench paper" the paper's
            scenes, tables and figures (on recordings of the demos, made first where they are missing), "bench
            stability" runs of 10 000 steps, "bench piles" meshes in piles with Bullet's own shapes, "bench queries" rays
            and sweeps, "bench terrain" convex bodies on hills, "bench fracture" a mesh that breaks with hulls, "bench
            ablation" the stages of manifolds, "bench gpu" layers on a GL device with sweep. Tables and pictures go to
            out/bench/.
            demos/gpu.sh runs the GL tests first, and packs all that for a machine with a GPU.
  report    One page with every table, plot, picture and film in out/, out/report/index.html. What is missing is run
            first, in small sizes; "report --all" runs everything afresh.
  gallery   Makes the README's pictures from the frames in out/.

With --view, cloth, fracture, breaking and leaves open a live window in place of files.

Arguments are the demo's own; "demos/run.sh DEMO --help" explains them.
END
}

# has_results STATUS: statuses from 2 on say that nothing was measured; 130: Ctrl-C ended it.
has_results()
{
    [ "$1" -le 1 ] || [ "$1" -ge 128 ]
}

# opens_window ARGUMENT...
opens_window()
{
    case " $* " in
        *' --view '* | *' --view-show'* | *' --view-screenshot'*) return 0 ;;
    esac
    return 1
}

# keep_output FILE COMMAND [ARGUMENT...]: keeps what a program prints in a file, below the command line, for the report.
keep_output()
{
    kept=$1
    shift
    mkdir -p "${kept%/*}"
    # Ctrl-C ends the program, not this script: what was done is kept, and what was drawn becomes a film.
    trap : INT
    {
        trap : INT
        status=0
        # By lines: a pipe would hold them back for minutes.
        stdbuf -oL "$@" || status=$?
        echo "$status" >"$kept.status"
    } | tee -i "$kept.new"
    trap - INT
    status=$(cat "$kept.status")
    if [ -s "$kept.new" ] && has_results "$status"; then
        {
            echo "$ $typed"
            cat "$kept.new"
            [ "$status" -eq 0 ] || echo "Exit status $status"
        } >"$kept"
    fi
    rm -f "$kept.new" "$kept.status"
    return "$status"
}

# set_film_aside NAME: pictures of a longer run before would end up in the film.
set_film_aside()
{
    mkdir -p "$root/out/$1/before"
    find "$root/out/$1" -maxdepth 1 \( -name '*_[0-9][0-9][0-9][0-9].png' -o -name "$1.mp4" \) \
        -exec mv -t "$root/out/$1/before" {} +
}

# end_film NAME FRAMES_A_SECOND STATUS: a film in place of the one before, which stays if there are no results.
end_film()
{
    if has_results "$3"; then
        make_film "$1" "$2"
    else
        find "$root/out/$1/before" -type f -exec mv -t "$root/out/$1" {} +
    fi
    rm -r "$root/out/$1/before"
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

# run_filmed NAME FRAMES_A_SECOND [ARGUMENT...]: a demo that draws, and a film of its frames; or its window.
run_filmed()
{
    name=$1
    rate=$2
    shift 2
    if opens_window "$@"; then
        exec "$root/build/demos/qc-$name" --out "$root/out/$name" "$@"
    fi
    set_film_aside "$name"
    status=0
    keep_output "$root/out/$name/$name.txt" "$root/build/demos/qc-$name" --out "$root/out/$name" "$@" || status=$?
    end_film "$name" "$rate" "$status"
    return "$status"
}

run_breaking()
{
    if "$root/demos/breaking/fetch_dragon.sh" "$root/build/models"; then
        set -- --dragon "$root/build/models/dragon_vrip.ply" "$@"
    fi
    # 120 steps a second, a frame every 12.
    run_filmed breaking 10 "$@"
}

run_through()
{
    set_film_aside through
    status=0
    keep_output "$root/out/through/through.txt" "$root/build/demos/qc-bench" through --frames "$root/out/through" \
        --csv "$root/out/through/through.csv" "$@" || status=$?
    # Four pictures a step.
    end_film through 12 "$status"
    return "$status"
}

run_bench()
{
    bench=$root/build/demos/qc-bench
    case ${1-} in
        '' | -*) run_benchmark accuracy "$@" ;;
        ablation)
            shift
            keep_output "$root/out/bench/ablation.txt" "$root/build/demos/qc-ablation" "$@"
            ;;
        paper)
            # Mistakes are found before the recordings are made, which takes long.
            "$bench" "$@" --help >/dev/null || return $?
            case "$*" in
                *--recordings*) ;;
                *) for scene in cloth breaking leaves; do make_recording "$scene"; done ;;
            esac
            run_benchmark "$@"
            ;;
        *) run_benchmark "$@" ;;
    esac
}

# show_answer ARGUMENT...: what the program says of itself.
show_answer()
{
    case $demo${1:+ $1} in
        through*) set -- through "$@" ;;
        'bench ablation') shift ;;
        'bench -h') set -- --help ;;
    esac
    exec "$root/build/demos/$program" "$@"
}

# make_recording DEMO: its recording for "bench paper", if it is missing. No device: all methods give the same run.
make_recording()
{
    recordings=$root/out/recordings
    if [ -f "$recordings/$1.qcr" ]; then
        return 0
    fi
    qc_build "$root" "qc-$1" >/dev/null || return 0
    echo "Recording the demo $1"
    mkdir -p "$recordings/new"
    demo=$1
    shift
    if [ "$demo" = breaking ] && "$root/demos/breaking/fetch_dragon.sh" "$root/build/models"; then
        set -- --dragon "$root/build/models/dragon_vrip.ply"
    fi
    "$root/build/demos/qc-$demo" "$@" --device none --method sweep --out "$recordings/new" \
        --record "$recordings/new/$demo.qcr" >/dev/null
    mv "$recordings/new"/*.qcr "$recordings/"
    rm -r "$recordings/new"
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
            accuracy | peers | first) set -- --dragon "$dragon" "$@" ;;
        esac
    fi
    keep_output "$root/out/bench/$name.txt" "$bench" "$name" --out "$root/out/bench" "$@"
}

typed="demos/run.sh${*:+ $*}"
demo=cloth
case ${1-} in
    -h | --help)
        show_help
        exit 0
        ;;
    report)
        shift
        exec "$(dirname -- "$0")/report/run.sh" "$@"
        ;;
    gallery)
        shift
        exec "$(dirname -- "$0")/gallery.sh" "$@"
        ;;
    cloth | fracture | breaking | leaves | gl-cloth | through | pairs | bench)
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

# One benchmark, by two names.
if [ "$demo ${1-}" = 'bench through' ]; then
    demo=through
    shift
fi
# shellcheck disable=SC2034 # Read by qc_install.
if opens_window "$@"; then
    qc_wishes=view
fi
case $demo in
    cloth | leaves) qc_install build demos ;;
    fracture | breaking | through) qc_install build demos models ;;
    bench)
        case ${1-} in
            peers | first) qc_install build bench peers ;;
            paper) qc_install build bench peers models ;;
            *) qc_install build bench ;;
        esac
        ;;
    *) qc_install build ;;
esac
program=qc-$demo
case $demo${1:+ $1} in
    through*) program=qc-bench ;;
    'bench ablation') program=qc-ablation ;;
esac
# The tests need more packages: they are built where tests/run.sh has been.
if [ -f "$root/build/CMakeCache.txt" ]; then
    qc_build "$root" "$program"
else
    qc_build "$root" "$program" -DQC_BUILD_TESTS=OFF
fi
# Questions change no results.
case " $* " in
    *' -h '* | *' --help '* | *' -? '* | *' --usage '* | *' --version '* | *' -V '*) show_answer "$@" ;;
esac
case $demo in
    # 120 steps a second, a frame every 10; 600 steps.
    cloth) run_filmed cloth 12 "$@" ;;
    fracture) run_filmed fracture 24 "$@" ;;
    breaking) run_breaking "$@" ;;
    # 120 steps a second, a frame every 10.
    leaves) run_filmed leaves 12 "$@" ;;
    through) run_through "$@" ;;
    gl-cloth) "$root/build/demos/qc-gl-cloth" "$@" ;;
    pairs) "$root/build/demos/qc-pairs" "$@" ;;
    bench) run_bench "$@" ;;
esac
