#!/bin/sh
# The rooms keep to themselves: who may include what, and what lies at the top. Prints each line that breaks a rule.
# test_layout.sh SOURCE_FOLDER
set -eu

cd "$1"
broken=0

# deny RULE PATTERN FILE...: no line of these files matches the pattern.
deny()
{
    rule=$1
    pattern=$2
    shift 2
    found=0
    for file in "$@"; do
        [ -f "$file" ] || continue
        found=1
        if grep -nHE "$pattern" "$file"; then
            echo "  breaks the rule: $rule"
            broken=1
        fi
    done
    if [ "$found" -eq 0 ]; then
        echo "no file to check for the rule: $rule"
        broken=1
    fi
}

include='^[[:space:]]*#[[:space:]]*include[[:space:]]*'
gl="${include}[<\"](GL|GLES[0-9]*|EGL|KHR|epoxy)/|${include}[<\"].*osmesa"
bullet="${include}[<\"](bullet/|bt[A-Z]|LinearMath/|Bullet[A-Z]|quickcullide/bullet)"

# GLU's tesselator is no GL; its header is.
# shellcheck disable=SC2046 # File names are words.
deny 'only plugin/gl includes GL' "$gl" \
    plugin/*.[ch] include/quickcullide/*.h $(find bullet_glue -type f ! -name bullet_glue/fracture/triangulate_face.cpp) demos/*.[ch]* \
    demos/*/*.[ch]* tests/*.[ch]* tests/*/*.[ch]*
deny 'the core does not know Bullet' "$bullet" plugin/*.[ch] plugin/gl/*.[ch]
deny 'the core includes nothing of the other rooms' "${include}[<\"](.*\.\./|demos/|tests/|bullet_glue/)" \
    plugin/*.[ch] plugin/gl/*.[ch]
deny 'demos and glue see the installed headers only' "${include}[<\"](.*\.\./|.*plugin/)" demos/*.[ch]* \
    demos/*/*.[ch]* bullet_glue/*.*
deny 'demos and glue see the installed headers only' 'qc_internal|qc_objects|/plugin' \
    demos/CMakeLists.txt bullet_glue/CMakeLists.txt
deny 'the C ABI includes its own headers and the C library only' "${include}(\"[^\"]*/|<[^>]*/)" \
    include/quickcullide/base.h include/quickcullide/boxes.h include/quickcullide/device.h \
    include/quickcullide/quickcullide.h include/quickcullide/scene.h

# A stage includes no header of a stage after it; plugin/pipeline/scene_api.c and detect.c see the whole line.
line='bodies plan visibility_sets triangles cull_visibility cull sweep objects parts candidates exact contact narrow manifold detect'
after=$line
for stage in $line; do
    after=${after#"$stage"}
    after=${after# }
    [ -n "$after" ] || break
    deny "$stage includes no stage after it" "${include}\"($(echo "$after" | tr ' ' '|'))\.h\"" \
        "plugin/$stage.h" "plugin/$stage.c" plugin/"$stage"_*.c
done
deny 'devices and shaders know no stage' "${include}\"($(echo "$line" | tr ' ' '|'))\.h\"" plugin/gl/*.[ch]

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
