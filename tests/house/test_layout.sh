#!/bin/sh
# Which folder may include which, as one table; which libraries' headers belong to which folder; what lies at the top.
#   test_layout.sh SOURCE_FOLDER          prints each line that breaks a rule, and fails if there is one
#   test_layout.sh SOURCE_FOLDER --graph  prints the includes that there are: folder, lines of code, folders it includes
set -eu

cd "$1"
show=${2:-}
top='plugin bullet_glue demos tests'

# A folder, and the folders that its sources and headers may include besides their own and include/. Folders stand from
# the bottom to the top: a row names rows above itself only, so there is no circle. A name that ends in /... allows all
# folders below it.
table='
plugin/base
plugin/plan                 plugin/base
plugin/mesh                 plugin/base
plugin/scene                plugin/base
plugin/triangle             plugin/base
plugin/kernels              plugin/base plugin/mesh
plugin/gl                   plugin/base plugin/plan
plugin/gl/picture           plugin/base plugin/gl
plugin/gl/visibility        plugin/base plugin/gl
plugin/gl/buffers           plugin/base plugin/gl
plugin/gl/layers            plugin/base plugin/gl plugin/kernels
plugin/broadphase           plugin/base
plugin/sweep/bvh            plugin/base plugin/mesh plugin/scene plugin/kernels
plugin/cull/visibility      plugin/base plugin/plan plugin/scene plugin/gl/visibility
plugin/cull/layers          plugin/base plugin/mesh plugin/scene plugin/kernels plugin/gl plugin/gl/buffers plugin/gl/layers
plugin/sweep                plugin/base plugin/plan plugin/mesh plugin/scene plugin/kernels plugin/sweep/bvh
plugin/narrowphase          plugin/base plugin/mesh plugin/scene plugin/triangle plugin/kernels plugin/sweep
plugin/manifold             plugin/base plugin/scene plugin/triangle
plugin/recording            plugin/base plugin/scene
plugin/pipeline             plugin/...

bullet_glue/common
bullet_glue/broadphase      bullet_glue/common
bullet_glue/debug_draw      bullet_glue/common
bullet_glue/mesh_shape      bullet_glue/common
bullet_glue/mesh_contact/points bullet_glue/common
bullet_glue/mesh_contact/scene bullet_glue/common bullet_glue/mesh_contact/points
bullet_glue/mesh_contact/planes bullet_glue/common bullet_glue/mesh_contact/points bullet_glue/mesh_contact/scene
bullet_glue/mesh_contact/limits bullet_glue/common bullet_glue/mesh_contact/scene bullet_glue/mesh_contact/planes
bullet_glue/mesh_contact    bullet_glue/common bullet_glue/mesh_contact/...
bullet_glue/queries         bullet_glue/common
bullet_glue/solver
bullet_glue/soft_body/scene bullet_glue/common
bullet_glue/soft_body/response bullet_glue/common bullet_glue/soft_body/scene
bullet_glue/soft_body       bullet_glue/common bullet_glue/soft_body/scene bullet_glue/soft_body/response
bullet_glue/fracture        bullet_glue/common
bullet_glue/preload

demos/common
demos/common/mesh_io        demos/common
demos/common/bullet         demos/common
demos/view                  demos/common/... demos/common
demos/hello
demos/gl_cloth              demos/common
demos/cloth                 demos/common/... demos/common demos/view
demos/fracture              demos/common/... demos/common demos/view
demos/breaking              demos/common/... demos/common demos/view
demos/leaves                demos/common/... demos/common demos/view
demos/pairs                 demos/common/... demos/common
demos/report                demos/common/... demos/common
demos/replay                demos/common
demos/bench/scenes          demos/common/... demos/common
demos/bench                 demos/common
demos/bench/accuracy        demos/bench demos/bench/scenes demos/common/... demos/common
demos/bench/broadphase      demos/bench demos/bench/scenes demos/common/... demos/common
demos/bench/peers           demos/bench demos/bench/scenes demos/common/... demos/common
demos/bench/first           demos/bench demos/bench/peers demos/bench/scenes demos/common
demos/bench/paper           demos/bench demos/bench/peers demos/common
demos/bench/ablation        demos/common
demos/bench/queries         demos/bench demos/bench/scenes demos/common/... demos/common
demos/bench/scaling         demos/bench demos/bench/scenes demos/common/... demos/common
demos/bench/gpu             demos/bench demos/bench/peers demos/bench/paper demos/bench/scenes demos/common/... demos/common
demos/bench/soft            demos/bench demos/bench/scenes demos/common/... demos/common
demos/bench/through         demos/bench demos/bench/scenes demos/common/... demos/common
demos/bench/piles           demos/bench demos/bench/through demos/common/... demos/common
demos/bench/terrain         demos/bench demos/bench/through demos/common
demos/bench/stability       demos/bench demos/bench/soft demos/bench/through demos/cloth demos/fracture demos/breaking demos/leaves demos/common/... demos/common
demos/bench/fracture        demos/bench demos/fracture demos/common/... demos/common

tests/support
tests/support/quick_check
tests/base                  tests/support plugin/base
tests/plan                  tests/support plugin/plan
tests/mesh                  tests/support plugin/base plugin/mesh
tests/triangle              tests/support plugin/base plugin/triangle
tests/sweep                 tests/support plugin/base plugin/mesh plugin/scene plugin/kernels plugin/sweep plugin/sweep/bvh
tests/kernels               tests/support tests/sweep plugin/base plugin/mesh plugin/kernels plugin/narrowphase
tests/gl                    tests/support plugin/base plugin/gl plugin/gl/visibility
tests/broadphase            tests/support plugin/base plugin/broadphase
tests/cull                  tests/support plugin/base plugin/scene plugin/cull/layers plugin/gl/layers plugin/pipeline
tests/narrowphase           tests/support
tests/manifold              tests/support plugin/base plugin/scene
tests/pipeline              tests/support demos/common/mesh_io
tests/recording             tests/support plugin/recording
tests/bullet                tests/support
tests/bullet/broadphase     tests/support tests/bullet
tests/bullet/mesh           tests/support tests/bullet bullet_glue/common bullet_glue/mesh_contact/... demos/common/mesh_io
tests/bullet/soft_body      tests/support tests/bullet tests/bullet/mesh bullet_glue/common bullet_glue/soft_body/scene bullet_glue/soft_body/response demos/bench/soft demos/cloth demos/leaves
tests/bullet/fracture       tests/support tests/bullet plugin/recording
tests/bullet/preload
tests/bullet/recording       tests/support tests/bullet/broadphase tests/bullet/mesh
tests/long                  tests/support tests/bullet/broadphase tests/bullet/mesh plugin/base plugin/scene plugin/broadphase plugin/pipeline bullet_glue/common
tests/tools                 tests/support demos/...
tests/models                demos/common/mesh_io
tests/fuzz                  tests/support tests/triangle plugin/base plugin/triangle demos/common/mesh_io
tests/fuzz/bullet           tests/fuzz tests/bullet/fracture
tests/house/golden
tests/house                 tests/support
tests/house/installed
'

# Of each quoted include: FILE:LINE FOLDER OF THE FILE, FOLDER OF WHAT IT INCLUDES. A name is looked for beside nothing:
# the path from the top of plugin/, bullet_glue/, demos/ or tests/ is written out.
includes=$(mktemp)
trap 'rm -f "$includes"' EXIT
# shellcheck disable=SC2086 # Folder names are words.
find $top \( -name '*.c' -o -name '*.h' -o -name '*.cpp' \) -type f |
    LC_ALL=C sort |
    xargs awk '
        FNR == 1 && file != "" { print file, "lines", lines }
        {
            file = FILENAME
            lines = FNR
        }
        /^[ \t]*#[ \t]*include[ \t]*"/ {
            name = $0
            sub(/^[^"]*"/, "", name)
            sub(/".*/, "", name)
            print file, FNR, name
        }
        END { print file, "lines", lines }' >"$includes"

TABLE=$table awk -v show="$show" -v top="$top" '
    function folder(path) { sub(/\/[^\/]*$/, "", path); return path }
    function exists(path,    line) {
        if (!(path in known)) {
            known[path] = (getline line < path) >= 0
            close(path)
        }
        return known[path]
    }
    function complain(text) { print text; broken = 1 }
    # True if a row allows the folder: named, or below a name that ends in /...
    function allows(from, to,    i, prefix) {
        if (from == to || index(" " allowed[from] " ", " " to " ") > 0)
            return 1
        for (i = 1; i <= wildcards[from]; ++i) {
            prefix = wildcard[from, i]
            if (substr(to, 1, length(prefix)) == prefix)
                return 1
        }
        return 0
    }
    BEGIN {
        rows = split(ENVIRON["TABLE"], row, "\n")
        for (r = 1; r <= rows; ++r) {
            count = split(row[r], word, " ")
            if (count == 0)
                continue
            name = word[1]
            order[++folders] = name
            for (i = 2; i <= count; ++i) {
                if (word[i] ~ /\/\.\.\.$/) {
                    wildcard[name, ++wildcards[name]] = substr(word[i], 1, length(word[i]) - 3)
                    continue
                }
                if (!(word[i] in number))
                    complain("the table: " name " names " word[i] ", which does not stand above it")
                allowed[name] = allowed[name] " " word[i]
            }
            number[name] = folders
        }
        roots = split(top, root, " ")
    }
    {
        from = folder($1)
        used[from] = 1
        if (!(from in number)) {
            if (!(from in missing))
                complain(from ": a folder that is not in the table")
            missing[from] = 1
            next
        }
        if ($2 == "lines") {
            lines[from] += $3
            next
        }
        if ($3 ~ /^quickcullide\// || $1 ~ /^tests\/house\/installed\//)
            next
        if ($3 ~ /^[a-z]*_shaders.h$/ || $3 ~ /^[a-z]*_script.h$/) # made by the build
            next
        if ($3 !~ /\//) {
            complain($1 ":" $2 ": \"" $3 "\": give the path from the top of the room")
            next
        }
        # The roots that the file sees, its own first.
        split($1, part, "/")
        target = ""
        own = part[1] "/" $3
        if (exists(own))
            target = own
        else if (part[1] == "tests")
            for (i = 1; i <= roots && target == ""; ++i)
                if (exists(root[i] "/" $3))
                    target = root[i] "/" $3
        if (target == "") {
            complain($1 ":" $2 ": \"" $3 "\": no such file in " part[1] "/")
            next
        }
        to = folder(target)
        edge[from] = index(edge[from] " ", " " to " ") || from == to ? edge[from] : edge[from] " " to
        if (!allows(from, to))
            complain($1 ":" $2 ": " from " may not include " to)
    }
    END {
        for (f = 1; f <= folders; ++f) {
            if (!(order[f] in used))
                complain("the table: " order[f] " has no sources")
            if (show == "--graph")
                printf "%-30s %6d  %s\n", order[f], lines[order[f]], edge[order[f]]
        }
        exit broken
    }' "$includes" || broken=1
broken=${broken:-0}

# deny RULE PATTERN FILE...: no line of these files matches the pattern.
deny()
{
    rule=$1
    pattern=$2
    shift 2
    [ $# -gt 0 ] || { echo "no file to check for the rule: $rule"; broken=1; }
    if grep -nHE "$pattern" "$@"; then
        echo "  breaks the rule: $rule"
        broken=1
    fi
}

include='^[[:space:]]*#[[:space:]]*include[[:space:]]*'
# shellcheck disable=SC2046 # File names are words.
{
    # GLU's tesselator is no GL; its header is. The live window draws on a display, and demos/gl_cloth shares its GL.
    deny 'only plugin/gl, demos/view and demos/gl_cloth include GL' "${include}[<\"](GL|GLES[0-9]*|EGL|KHR|epoxy)/|${include}[<\"].*osmesa" \
        $(find plugin include bullet_glue demos tests -name '*.[ch]*' -type f ! -path 'plugin/gl/*' ! -path 'demos/view/*' \
            ! -path 'demos/gl_cloth/*' ! -name triangulate_face.cpp)
    deny 'the core is free of Bullet' "${include}[<\"](bullet/|bt[A-Z]|LinearMath/|Bullet[A-Z]|quickcullide/bullet)" \
        $(find plugin -name '*.[ch]')
    deny 'no path leads upwards' "${include}[<\"].*\.\./" $(find plugin bullet_glue demos tests -name '*.[ch]*' -type f)
    deny 'demos and glue see the installed headers only' 'qc_internal|qc_objects|/plugin' \
        demos/CMakeLists.txt bullet_glue/CMakeLists.txt
    deny 'the C ABI includes its own headers and the C library only' "${include}(\"[^\"]*/|<[^>]*/)" \
        $(find include -name '*.h' ! -name 'bullet*')
}

# Files of a folder that are compiled together (qc_compile_together): the compiler takes two functions of unnamed
# namespaces that share a name for overloads, and a call may then reach the other file's.
find bullet_glue demos/bench demos/view demos/cloth demos/leaves demos/breaking demos/fracture demos/common/bullet \
    tests/bullet -name '*.cpp' -type f ! -path 'bullet_glue/fracture/*' | LC_ALL=C sort | xargs awk '
        FNR == 1 {
            inside = 0
            folder = FILENAME
            sub(/\/[^\/]*$/, "", folder)
        }
        /^namespace$/ { inside = 1; next }
        /^}/ && / namespace$/ { inside = 0 }
        inside && /^[A-Za-z].*[ *&][A-Za-z_0-9]+\(/ && !/^(class|struct|enum|constexpr|const|static|using|template) / {
            sub(/\(.*/, "")
            sub(/.*[ *&]/, "")
            if (seen[folder, $0, FILENAME]++ == 0 && ++files[folder, $0] == 2) {
                print folder ": several files have a function of this name in unnamed namespaces: " $0
                broken = 1
            }
        }
        END { exit broken }' || broken=1

# What .gitignore names may lie about too.
for entry in * .[!.]*; do
    case $entry in
        CMakeLists.txt | LICENSE | README.md | bullet_glue | demos | include | plugin | tests | .* | build* | out) ;;
        *)
            echo "$entry: has no place at the top"
            broken=1
            ;;
    esac
done

exit "$broken"
