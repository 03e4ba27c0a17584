#!/usr/bin/env bash
# Makes the pictures of the docs. Needs Debian's chromium.
set -euo pipefail
cd "$(dirname "$0")/../.."
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
cargo run --release -- run beat --receivers bypass,sync --set duration-s=12 --set 'expect=[]' --no-trace --out "$out"
chromium --headless --no-sandbox --disable-gpu --disable-background-networking --no-first-run \
    --hide-scrollbars --user-data-dir="$out/chromium" --virtual-time-budget=15000 \
    --window-size=1240,1260 --screenshot=docs/pictures/beat.png "file://$out/report.html"
