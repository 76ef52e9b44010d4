# Writes a text file into a C header, as a string: cmake -D IN=... -D OUT=... -D NAME=... -P embed.cmake
file(READ ${IN} text)
string(REPLACE "\\" "\\\\" text "${text}")
string(REPLACE "\"" "\\\"" text "${text}")
string(REPLACE "\n" "\\n\"\n    \"" text "${text}")
get_filename_component(file ${IN} NAME)
file(WRITE ${OUT} "// Made from ${file} by embed.cmake.\nstatic const char ${NAME}[] =\n    \"${text}\";\n")
