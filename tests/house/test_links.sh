#!/bin/sh
# Relative links and pictures in the documents lead to files that exist. test_links.sh SOURCE_FOLDER
set -eu

cd "$1"
broken=0
count=0
for document in README.md plugin/docs/*.md plugin/docs/*/*.md; do
    [ -f "$document" ] || continue
    folder=$(dirname "$document")
    for link in $(sed '/^```/,/^```$/d' "$document" | grep -oE '\]\([^)]*\)' | sed 's/^](//; s/)$//; s/#.*//'); do
        case $link in
            http://* | https://*) continue ;;
        esac
        count=$((count + 1))
        if [ ! -e "$folder/$link" ]; then
            echo "$document: $link does not exist"
            broken=1
        fi
    done
done
echo "$count links"
[ "$count" -gt 0 ] || broken=1
exit "$broken"
