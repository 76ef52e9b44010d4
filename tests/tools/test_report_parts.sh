#!/bin/sh
# Every line of demos/report/parts.txt is a command line that its program accepts, in full size and in quick form.
#   test_report_parts.sh SOURCE_FOLDER BUILD_FOLDER
set -eu

source=$1
build=$2
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
mkdir -p demos/breaking tests build/demos out/recordings
cp "$source/demos/run.sh" demos/
printf 'qc_install() { :; }\nqc_build() { :; }\n' >tests/setup.sh
# No dragon.
printf '#!/bin/sh\nexit 1\n' >demos/breaking/fetch_dragon.sh
chmod +x demos/breaking/fetch_dragon.sh
for scene in cloth breaking leaves; do
    touch out/recordings/$scene.qcr
done

# Each program ends after its command line, as its output can't be written. qc-ablation writes none: it is stopped.
for program in cloth fracture breaking leaves bench ablation; do
    cat >build/demos/qc-$program <<END
#!/bin/sh
case "$program \${1-}" in
    'bench through') set -- "\$@" --csv /dev/null/none ;;
    ablation*)
        status=0
        timeout 1 "$build/demos/qc-ablation" "\$@" || status=\$?
        [ "\$status" -eq 124 ] && exit 1
        exit "\$status"
        ;;
    *) set -- "\$@" --out /dev/null/none ;;
esac
exec "$build/demos/qc-$program" "\$@"
END
    chmod +x build/demos/qc-$program
done

failed=0
count=0
while IFS='|' read -r name arguments quick _ <&3; do
    case $name in
        '' | '#'*) continue ;;
    esac
    for options in '' "$quick"; do
        status=0
        # shellcheck disable=SC2086 # Arguments are words.
        output=$(sh demos/run.sh $arguments $options 2>&1) || status=$?
        if [ "$status" -ne 1 ]; then
            echo "$arguments $options: status $status, $output"
            failed=1
        fi
    done
    count=$((count + 1))
done 3<"$source/demos/report/parts.txt"
[ "$count" -ge 19 ] || failed=1
exit "$failed"
