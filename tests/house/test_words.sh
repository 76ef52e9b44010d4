#!/bin/sh
# Comments say what data is, in the field's words. Prints each comment line in which data speaks, or that begins with "Of",
# "As" or "The same", and each file whose head is longer than eight lines.
#   test_words.sh SOURCE_FOLDER [FOLDER...]   by default plugin, include, bullet_glue, demos and tests
set -eu

cd "$1"
shift
[ $# -gt 0 ] || set -- plugin include bullet_glue demos tests

find "$@" \( -name '*.[ch]' -o -name '*.cpp' -o -name '*.comp' -o -name '*.glsl' \) -type f | LC_ALL=C sort |
    xargs awk '
    function complain(text) { print FILENAME ":" FNR ": " text; broken = 1 }
    # The comment of a line, without its marks; strings of program text are not comments.
    function comment(line,    at) {
        gsub(/"([^"\\]|\\.)*"/, "\"\"", line)
        at = match(line, /\/\/+<?[ \t]*/)
        return at ? substr(line, at + RLENGTH) : ""
    }
    FNR == 1 { head = 0; inHead = 1 }
    {
        if (inHead && $0 ~ /^\/\//) {
            if (++head == 9)
                complain("the head of the file has more than 8 lines")
        } else
            inHead = 0
        text = comment($0)
        if (text == "")
            next
        lower = " " tolower(text) " "
        gsub(/[^a-z'"'"']/, " ", lower)
        if (match(lower, / (asked|asks|told|tells|heard|unheard|wished|wishes|wanted|wants|knows|says) /))
            complain(substr(lower, RSTART + 1, RLENGTH - 2) ": " text)
        if (match(lower, / meets itself /))
            complain("meets itself: " text)
        # A sentence that begins so, at the beginning of a comment or after a full stop.
        begins = $0 ~ /^[ \t]*\/\// && previous !~ /[a-z0-9,;:)]$/ ? text : ""
        if (begins ~ /^(Of|As|The same) / || text ~ /[.:!?] (Of|The same) /)
            complain("begins with Of, As or The same: " text)
    }
    { previous = comment($0) }
    END { exit broken }'
