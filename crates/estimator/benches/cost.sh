#!/bin/sh
# Thousand instructions of fusion an image, or a late image, in cases of the bench `fusion`. Needs valgrind.
# What a busy machine can't change: the images are made and the machine is set up outside of the count.
#
#   crates/estimator/benches/cost.sh [CASE..]                  instructions of each case (default: all)
#   crates/estimator/benches/cost.sh --stages CASE [PATTERN]   those that functions take, callees included
set -eu
cd "$(dirname "$0")/../../.."
bench=$(cargo bench --package sextant-estimator --bench fusion --no-run 2>&1 | sed -n 's/.*Executable .*(\(.*\))/\1/p')
out=$(mktemp)
trap 'rm -f "$out"' EXIT

# Images that are timed in a case.
images() {
    case $1 in
        late) echo 390 ;;
        clock | ahead | behind) echo 900 ;;
        free-running | simultaneous) echo 3840 ;;
        *) echo 4000 ;;
    esac
}

count() {
    timed='*timed*'
    [ "$1" != late ] || timed='*timed_late*'
    valgrind --tool=callgrind --callgrind-out-file="$out" --collect-atstart=no --toggle-collect="$timed" \
        "$bench" --once "$1" 2>&1 |
        sed -n 's/.*Collected : //p'
}

if [ "${1:-}" = --stages ]; then
    count "$2" >"$out.count" && rm "$out.count"
    callgrind_annotate --inclusive=yes --threshold=100 "$out" | grep -E "${3:-sextant_estimator}" |
        awk -v images="$(images "$2")" '{
            gsub(",", "", $1)
            name = $NF == "" ? $0 : substr($0, index($0, ":") + 1)
            if ($1 > 0) printf "%10.1f  %s\n", $1 / images / 1000, name
        }' |
        head -40
    exit
fi
[ $# -gt 0 ] || set -- 1-tag 6-tags lasting arm body late clock ahead behind free-running simultaneous
for case in "$@"; do
    count "$case" |
        awk -v case="$case" -v images="$(images "$case")" '{ printf "%-14s %9.1f\n", case, $1 / images / 1000 }'
done
