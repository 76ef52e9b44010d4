#!/bin/sh
# Runs the demos and benchmarks whose results are missing, and writes one page of all results: demos/run.sh report.
set -eu

show_help()
{
    cat <<'END'
Usage: demos/run.sh report [OPTION...]

Writes out/report/index.html: every table, plot, picture and film in out/, the machine and the versions, in one file.
What is missing is run first, in small sizes.

  --all      Runs everything afresh, in full size, which takes hours
  --only-page  Runs nothing: what is missing is named in the page
END
}

root=$(CDPATH='' cd -- "$(dirname -- "$0")/../.." && pwd)
out=$root/out
all=
only_page=
for option in "$@"; do
    case $option in
        -h | --help)
            show_help
            exit 0
            ;;
        --all) all=1 ;;
        --only-page) only_page=1 ;;
        *)
            echo "demos/run.sh report: unrecognized option '$option'; try --help" >&2
            exit 2
            ;;
    esac
done

# run_part NAME ARGUMENTS QUICK: as demos/run.sh would be called by hand.
# shellcheck disable=SC2086 # Arguments are words.
run_part()
{
    quick=$3
    [ -z "$all" ] || quick=
    echo
    echo "== demos/run.sh $2${quick:+ $quick}"
    status=0
    "$root/demos/run.sh" $2 $quick || status=$?
    [ "$status" -eq 0 ] || echo "demos/run.sh report: $1 ended with status $status" >&2
}

# is_there NAME ARGUMENTS: true if there are results of a part, of a run that was not ended by Ctrl-C.
is_there()
{
    case $2 in
        'bench '*) text=$out/bench/${2#bench }.txt ;;
        *) text=$out/$1/$1.txt ;;
    esac
    [ -f "$text" ] && ! tail -n 1 "$text" | grep -q '^Exit status 130$'
}

run_parts()
{
    # The parts on another descriptor: programs may read standard input.
    while IFS='|' read -r name arguments quick _ <&3; do
        case $name in
            '' | '#'*) continue ;;
        esac
        if [ -n "$all" ] || ! is_there "$name" "$arguments"; then
            [ -z "$interrupted" ] || continue
            run_part "$name" "$arguments" "$quick"
        fi
    done 3<"$root/demos/report/parts.txt"
}

# Plots as SVG, sharp at any size.
draw_again()
{
    command -v gnuplot >/dev/null || return 0
    for script in "$out"/bench/*.gp; do
        [ -f "$script" ] || continue
        (cd "$out/bench" && gnuplot -e 'svg = 1' "${script##*/}") >/dev/null 2>&1 || true
    done
}

# Films in out/report/films, small enough for a page.
shrink_films()
{
    mkdir -p "$out/report/films"
    command -v ffmpeg >/dev/null || return 0
    for film in "$out"/*/*.mp4; do
        small=$out/report/films/${film##*/}
        [ -f "$film" ] || continue
        if [ ! -f "$small" ] || [ -n "$(find "$film" -newer "$small")" ]; then
            ffmpeg -nostdin -loglevel error -y -i "$film" -an -vf "scale='min(960,iw)':-2" -c:v libx264 -profile:v baseline \
                -preset slow -crf 30 -pix_fmt yuv420p -movflags +faststart "$small" || rm -f "$small"
        fi
    done
}

# Ctrl-C ends what runs, and the page shows what there is.
interrupted=
trap 'interrupted=1' INT
[ -n "$only_page" ] || run_parts
draw_again
shrink_films
# shellcheck source=/dev/null
. "$root/tests/setup.sh"
qc_install build bench demos
qc_build "$root" qc-report >/dev/null
revision=$(git -C "$root" describe --always --dirty 2>/dev/null || true)
set -- --from "$out" --films "$out/report/films" --page "$out/report/index.html"
"$root/build/demos/qc-report" "$@" ${revision:+--revision "$revision"}
[ -z "$interrupted" ] || exit 130
