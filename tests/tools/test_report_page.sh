#!/bin/sh
# The report in headless Chromium: every picture is drawn, and the page is no wider than a phone, nor than a desktop.
# Exit status 77 (skipped) where Chromium is not installed.
#   test_report_page.sh QC_REPORT
set -eu

if ! command -v chromium >/dev/null; then
    echo "Skipped: Chromium is not installed"
    exit 77
fi
report=$1
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"

# Results that are wider than a phone.
mkdir -p out/cloth out/bench
for i in 1 2; do
    echo iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR4nGNgYPj/HwADAgH/p7QStAAAAABJRU5ErkJggg== |
        base64 --decode >"out/cloth/frame_000$i.png"
done
echo '<svg xmlns="http://www.w3.org/2000/svg" width="1400" height="9"><rect width="9" height="9" /></svg>' >out/bench/peers.svg
awk 'BEGIN {
    print "$ demos/run.sh bench peers --with a --very long --command line --that does --not fit --on a --phone at --all"
    for (i = 0; i < 300; ++i) printf "x"
    print ""
}' >out/bench/peers.txt
awk 'BEGIN { for (i = 0; i < 40; ++i) printf "column%d,", i; print ""; for (i = 0; i < 40; ++i) printf "%d,", i * 1e8; print "" }' \
    >out/bench/scaling_boxes.csv
"$report" --page page.html

# A page around the page looks into it.
cat >around.html <<'END'
<html><body><iframe id="page" src="page.html"></iframe><pre id="result"></pre><script>
const page = document.getElementById("page");
page.onload = async () => {
    let text = "";
    for (const width of [390, 1280]) {
        page.style.width = width + "px";
        await new Promise(done => setTimeout(done, 300));
        const all = page.contentDocument.documentElement;
        text += `width ${width}: ${all.scrollWidth <= all.clientWidth ? "fits" : "is " + all.scrollWidth}; `;
    }
    const images = [...page.contentDocument.images];
    text += `${images.filter(image => image.complete && image.naturalWidth > 0).length} of ${images.length} pictures`;
    document.getElementById("result").textContent = text;
};
</script></body></html>
END
timeout 120 chromium --headless --no-sandbox --disable-gpu --allow-file-access-from-files --user-data-dir="$work/profile" \
    --virtual-time-budget=20000 --dump-dom "file://$work/around.html" >dom.html 2>chromium.log || {
    cat chromium.log
    exit 1
}
result=$(sed -n 's/.*<pre id="result">\([^<]*\)<.*/\1/p' dom.html)
echo "$result"
[ "$result" = "width 390: fits; width 1280: fits; 3 of 3 pictures" ]
