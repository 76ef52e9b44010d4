# Writes the kernels into a C header, one string each: cmake -D OUT=... -D FOLDER=... -P embed.cmake
set(text "// Generated from plugin/gl/layers/shaders by embed.cmake.\n")
foreach(pair Common:common.glsl Vertices:vertices.comp Boxes:boxes.comp Nodes:nodes.comp NodePairs:node_pairs.comp
        ClusterPairs:cluster_pairs.comp TrianglePairs:triangle_pairs.comp Filter:filter.comp)
  string(REPLACE ":" ";" pair ${pair})
  list(GET pair 0 name)
  list(GET pair 1 file)
  file(READ ${FOLDER}/${file} source)
  string(REPLACE "\\" "\\\\" source "${source}")
  string(REPLACE "\"" "\\\"" source "${source}")
  string(REPLACE "\n" "\\n\"\n    \"" source "${source}")
  string(APPEND text "static const char s_layers${name}[] =\n    \"${source}\";\n")
endforeach()
file(WRITE ${OUT} "${text}")
