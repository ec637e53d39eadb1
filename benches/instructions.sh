#!/bin/sh
# Million instructions and best time of one detection, for each kind of image and each detector. Needs valgrind.
# Instructions are the difference between 1 + 9 and 1 detections, so that starting and the first image do not count.
#
#   benches/instructions.sh [sextant] [edges] [tracking] [c] [c20]      (c and c20 are AprilTag's own detector)
set -eu
cd "$(dirname "$0")/.."
[ $# -gt 0 ] || set -- sextant edges tracking c c20
cargo build --quiet --release --package sextant-benches --features peer
repeat=${CARGO_TARGET_DIR:-target}/release/repeat
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
"$repeat" write "$work/images"

instructions() {
    valgrind --tool=callgrind --callgrind-out-file=/dev/null "$repeat" "$1" "$2" "$3" 2>&1 |
        sed -n 's/.*Collected : //p'
}

for detector in "$@"; do
    for image in empty 1-tag 3-tags 12-tags clutter 3-tags-noise-8; do
        file=$work/images/$image
        few=$(instructions "$detector" "$file" 1)
        more=$(instructions "$detector" "$file" 10)
        million=$(echo "$few $more" | awk '{ printf "%.2f", ($2 - $1) / 9e6 }')
        time="$("$repeat" "$detector" "$file" 200)"
        printf '%-8s %-15s %8s M instructions  %s\n' "$detector" "$image" "$million" "$time"
    done
done
