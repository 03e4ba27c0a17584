#!/usr/bin/env bash
# Makes the pictures of the docs. Needs Debian's chromium.
set -euo pipefail
cd "$(dirname "$0")/../.."
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT

# picture <page> <name> <size>
picture() {
    chromium --headless --no-sandbox --disable-gpu --disable-background-networking --no-first-run \
        --hide-scrollbars --user-data-dir="$out/chromium" --virtual-time-budget=15000 \
        --window-size="$3" --screenshot="docs/pictures/$2.png" "file://$1"
}

cargo run --release -- run cut-to-length --set 'expect=[]' --no-trace --out "$out"
picture "$out/report.html" cut 1240,1620
cargo run --release -- run beat --receivers bypass,sync --set duration-s=12 --set 'expect=[]' --no-trace --out "$out"
picture "$out/report.html" beat 1240,1500
cargo run --release -- cam plot scenarios/cams/rotary-knife.toml -o "$out/cam.html"
picture "$out/cam.html" cam 1100,1230
cargo run --release -- saw plot scenarios/saws/saw-position-1.toml -o "$out/saw.html"
picture "$out/saw.html" saw 1100,1280
# The scope's is what its test sees; that needs chromium-driver too.
cargo test -p coaxle-tests --test processes watched::page::a_beat_is_found
cp target/tmp/scope.png docs/pictures/scope.png
# The designer's and the saw's as their tests see them.
cargo test -p coaxle-tests --test processes watched::designer::
cp target/tmp/designer.png target/tmp/saw-editor.png docs/pictures/
