#!/bin/sh
# Million instructions of one detection on 32-bit ARM with NEON (as on a Cortex-A9), for each kind of image. Needs
# qemu-arm of qemu-user with plugins (Debian's has them), a C compiler, and arm-linux-gnueabihf-gcc. Instructions are
# the difference between 1 + 9 and 1 detections, so that starting and the first image do not count.
#
#   benches/armv7-instructions.sh [sextant] [edges] [tracking]
set -eu
cd "$(dirname "$0")/.."
[ $# -gt 0 ] || set -- sextant edges tracking
target=thumbv7neon-unknown-linux-gnueabihf
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cc -O2 -shared -fPIC -o "$work/count.so" benches/count-instructions.c
cargo build --quiet --release --package sextant-benches --bin repeat
cargo build --quiet --release --package sextant-benches --bin repeat --target "$target"
built=${CARGO_TARGET_DIR:-target}
"$built/release/repeat" write "$work/images"

instructions() {
    qemu-arm -L /usr/arm-linux-gnueabihf -cpu cortex-a9 -plugin "$work/count.so" \
        "$built/$target/release/repeat" "$1" "$2" "$3" 2>&1 | sed -n 's/^instructions: //p'
}

for detector in "$@"; do
    for image in empty 1-tag 3-tags 12-tags clutter 3-tags-noise-8; do
        file=$work/images/$image
        few=$(instructions "$detector" "$file" 1)
        more=$(instructions "$detector" "$file" 10)
        million=$(echo "$few $more" | awk '{ printf "%.2f", ($2 - $1) / 9e6 }')
        printf '%-8s %-15s %8s M instructions\n' "$detector" "$image" "$million"
    done
done
