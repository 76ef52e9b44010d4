#!/bin/sh
# demos/run.sh with stand-ins for the programs: --help and mistakes leave the results of a run before, a new run
# replaces them, and a live window opens in place of files.
#   test_demos_run.sh SOURCE_FOLDER
set -eu

source=$1
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
mkdir -p demos/breaking tests build/demos out/cloth out/through
cp "$source/demos/run.sh" demos/
cat >tests/setup.sh <<'END'
qc_install() { echo "wishes: ${qc_wishes-}"; }
qc_build() { :; }
END
cat >demos/breaking/fetch_dragon.sh <<'END'
#!/bin/sh
mkdir -p "$1"
echo ply >"$1/dragon_vrip.ply"
END
cat >build/demos/qc-cloth <<'END'
#!/bin/sh
echo "arguments: $*"
case "$*" in
    *--ends-with*) exit "${*##*--ends-with }" ;;
esac
END
for name in qc-breaking qc-bench; do
    cp build/demos/qc-cloth build/demos/$name
done
chmod +x build/demos/* demos/breaking/fetch_dragon.sh

run()
{
    status=0
    output=$(sh demos/run.sh "$@" 2>&1) || status=$?
}

fail()
{
    echo "$*: status $status, $output"
    exit 1
}

# has_printed WORDS
has_printed()
{
    case $output in
        *"$1"*) ;;
        *) fail "no '$1'" ;;
    esac
}

make_results()
{
    for name in frame_0000.png frame_0071.png with_cullide_0011.png cloth.mp4 cloth.txt shot.png; do
        echo before >"out/cloth/$name"
    done
    echo before >out/through/frame_0000.png
}

# are_there COUNT: files of the run before, in all of out/.
are_there()
{
    [ "$(find out -type f -exec grep -l '^before$' {} + | wc -l)" -eq "$1" ] || fail "$(find out -type f)"
    [ -z "$(find out -name before)" ] || fail "out/*/before stayed"
}

make_results
for question in --help '-?' --usage --version -V; do
    run cloth "$question"
    are_there 7
    run through "$question"
    are_there 7
    has_printed "arguments: through $question"
done
run cloth --ends-with 2
[ "$status" -eq 2 ] || fail cloth
are_there 7
run through --ends-with 4
are_there 7
run cloth --view-show pcs
are_there 7
has_printed 'wishes: view'
has_printed 'arguments: --out '
run breaking --view
has_printed "--dragon $work/build/models/dragon_vrip.ply --view"
run bench -h
has_printed 'arguments: --help'

# The picture of another name is the user's.
for end in 0 1 130; do
    make_results
    run cloth --ends-with $end
    [ "$status" -eq $end ] || fail cloth
    are_there 2
    grep -q '^arguments: ' out/cloth/cloth.txt
done
run bench through --quick
has_printed "arguments: through --frames $work/out/through"
are_there 1
