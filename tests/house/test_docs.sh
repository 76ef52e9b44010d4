#!/bin/sh
# Doxygen reads the public headers without a warning. Exit status 77 (skipped) where it is not installed.
# test_docs.sh DOXYFILE
set -eu

if ! command -v doxygen >/dev/null; then
    echo "Doxygen is not installed"
    exit 77
fi
exec doxygen "$1"
