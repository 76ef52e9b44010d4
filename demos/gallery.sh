#!/bin/sh
# Makes the README's pictures from the frames that the demos have left in out/: demos/run.sh gallery
#   demos/NAME/NAME.png: moments of a run side by side; below them the same with the PCS in red, where frames have it.
#   demos/view/view.png: the live window, drawn anew where xvfb-run is installed.
set -eu

case ${1-} in
    -h | --help)
        sed -n '2,/^set/s/^# \{0,1\}//p' "$0"
        exit 0
        ;;
    '') ;;
    *)
        echo "demos/gallery.sh: there is no option '$1'; try --help" >&2
        exit 2
        ;;
esac
root=$(CDPATH='' cd -- "$(dirname -- "$0")/.." && pwd)
command -v ffmpeg >/dev/null || { echo "demos/gallery.sh: ffmpeg is missing; install the package ffmpeg" >&2; exit 1; }

# frame NAME PERCENT: the frame at this part of the run. 100: the last one.
frame()
{
    count=$(find "$root/out/$1/" -name 'frame_*.png' | wc -l)
    printf '%s/out/%s/frame_%04d.png' "$root" "$1" $(((count - 1) * $2 / 100))
}

# strip NAME ROWS CROP WIDTH PERCENT...: CROP is width:height:left:top in a half of a frame; ROWS is 2 where frames have a
# half with the PCS; WIDTH is that of a cell in the picture. 255 colours keep the file small.
strip()
{
    name=$1
    rows=$2
    crop=$3
    width=$4
    shift 4
    if [ ! -f "$root/out/$name/frame_0000.png" ]; then
        echo "$name: no frames in out/$name; run demos/run.sh $name first"
        return
    fi
    picture=$root/demos/$name/$name.png
    columns=$#
    parts=
    inputs=
    cells=
    i=0
    for percent; do
        parts="$parts -i $(frame "$name" "$percent")"
        scale="scale=$width:-2:flags=area"
        if [ "$rows" = 2 ]; then
            cells="${cells}[$i]split[a$i][b$i];[a$i]crop=in_w/2:in_h:0:0,crop=$crop,${scale}[l$i];"
            cells="${cells}[b$i]crop=in_w/2:in_h:in_w/2:0,crop=$crop,${scale}[r$i];[l$i][r$i]vstack[c$i];"
        else
            cells="${cells}[$i]crop=$crop,${scale}[c$i];"
        fi
        inputs="${inputs}[c$i]"
        i=$((i + 1))
    done
    # shellcheck disable=SC2086 # Options and paths, which have no blanks but those of the folder.
    ffmpeg -loglevel error -y $parts -filter_complex \
        "$cells${inputs}hstack=inputs=$columns,split[x][y];[x]palettegen=max_colors=255[p];[y][p]paletteuse=dither=none" \
        "$picture"
    echo "$picture: $(($(wc -c <"$picture") / 1024)) KB"
}

strip cloth 2 800:590:0:30 380 59 78 100
strip breaking 2 in_w:in_h:0:0 380 5 50 100
strip leaves 2 in_w:in_h:0:0 380 4 40 76
strip fracture 1 in_w:in_h:0:0 380 0 20 100

window=$(mktemp -d)
trap 'rm -rf "$window"' EXIT
if command -v xvfb-run >/dev/null && [ -x "$root/build/demos/qc-cloth" ] &&
    xvfb-run -a -s '-screen 0 1280x800x24' "$root/build/demos/qc-cloth" --view --triangles 8000 --method sweep \
        --view-frames 100 --view-show pcs,candidates,contacts --view-screenshot "$window/view.png" --out "$window"; then
    picture=$root/demos/view/view.png
    ffmpeg -loglevel error -y -i "$window/view.png" -filter_complex \
        "[0]scale=1140:-2:flags=area,split[x][y];[x]palettegen=max_colors=255[p];[y][p]paletteuse=dither=none" "$picture"
    echo "$picture: $(($(wc -c <"$picture") / 1024)) KB"
else
    echo "view: no picture of the window"
fi
