#!/bin/sh
# Relative links and pictures in the documents lead to files that exist. test_links.sh SOURCE_FOLDER
set -eu

cd "$1"
links=$(mktemp)
trap 'rm -f "$links"' EXIT

# Blocks of code have no links.
find README.md plugin/docs -name '*.md' -exec awk '
    /^```/ { code = !code }
    {
        line = code ? "" : $0
        while (match(line, /\]\([^)#]+/)) {
            print FILENAME, substr(line, RSTART + 2, RLENGTH - 2)
            line = substr(line, RSTART + RLENGTH)
        }
    }' {} + >"$links"

broken=0
while read -r document link; do
    case $link in
        http://* | https://*) continue ;;
    esac
    if [ ! -e "$(dirname "$document")/$link" ]; then
        echo "$document: $link does not exist"
        broken=1
    fi
done <"$links"
echo "$(wc -l <"$links") links"
[ -s "$links" ] || broken=1
exit "$broken"
