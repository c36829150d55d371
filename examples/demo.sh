#!/usr/bin/env bash
# From a name to three verdicts: what `make demo` runs.  All files go into ./demo, and all talk into demo/log.txt.
set -euo pipefail
cd "$(dirname "$0")/.."
registry=sqlite:///demo/people.sqlite3
log=demo/log.txt
# The key that signs these records stays with the demo, apart from any that signs real badges.
export MOIREID_KEYS=demo/keys
mkdir -p demo
# Each run draws new identities.  With the last run's registry two badges would bear one name.
rm -f demo/people.sqlite3
: > "$log"
number=0

# Says what is done next, and why.
step() {
    number=$((number + 1))
    printf '\n%d. %s\n' "$number" "$1"
}

# Shows a command, so that it can be pasted, and runs it.  It must end with the exit code given first, else the demo ends with what it said.
run() {
    local wanted=$1 got=0 word
    shift
    printf '   $'
    for word; do
        case $word in *[!-A-Za-z0-9_./:]*) word="\"$word\"" ;; esac
        printf ' %s' "$word"
    done
    echo
    "$@" > demo/said.txt 2>&1 || got=$?
    cat demo/said.txt >> "$log"
    if [ "$got" -ne "$wanted" ]; then
        cat demo/said.txt
        echo "demo: that command should end with exit code $wanted, but ended with $got" >&2
        exit 1
    fi
}

# One line of result.
result() {
    printf '   -> %s\n' "$1"
}

# Verifies a film; the result is the verdict's headline.
verdict() {
    run "$@"
    result "$(grep -m 1 -E '^(ACCEPT|REJECT)' demo/said.txt)."
}

echo "This takes about a minute; the first time Numba compiles as well, which takes another."

step "Print: design a badge for Ada, and one for Grace. Each is a page of lines to put under a lenticular sheet."
run 0 print-your-badge "Ada Lovelace" --out demo/ada --overwrite
run 0 print-your-badge "Grace Hopper" --out demo/grace --mount none --overwrite
result "demo/ada holds the page to print, instructions, and a mount to 3D-print or to laser-cut"

step "Enroll: note in a registry who holds which badge, so that a film can be compared with it."
run 0 moireid enroll demo/ada/badge.json --registry "$registry"
run 0 moireid enroll demo/grace/badge.json --registry "$registry"
result "the registry is demo/people.sqlite3"

step "Film: we have no camera here, so simulate one that moves around Ada, who wears it; then forge the same film."
film="--scene worn --camera webcam --motion circle --distance 0.6 --frames 100 --fps 30 --overwrite"
# shellcheck disable=SC2086  # These are several words.
run 0 moireid simulate demo/ada/badge.json --out demo/ada.mp4 $film
# shellcheck disable=SC2086
run 0 moireid simulate demo/ada/badge.json --out demo/forged.mp4 --forge frozen $film
result "demo/ada.mp4, and demo/forged.mp4, in which the fringes stay still as they would in a printed picture"

step "Verify: is it Ada's badge?"
verdict 0 moireid verify demo/ada.mp4 --claim "Ada Lovelace" --registry "$registry" --report demo/report --overwrite

step "Verify the same film against another name: is it Grace's badge?"
verdict 1 moireid verify demo/ada.mp4 --claim "Grace Hopper" --registry "$registry"

step "Verify the forged film: is it Ada's badge?"
verdict 1 moireid verify demo/forged.mp4 --claim "Ada Lovelace" --registry "$registry" --report demo/report-forged --overwrite

python examples/side_by_side.py demo/true_and_forged.mp4 "Real badge" demo/ada.mp4 demo/report \
    "Forged: a still picture of the badge" demo/forged.mp4 demo/report-forged > demo/said.txt
rm demo/said.txt

cat <<END

Done. Look at, in this order:
  demo/true_and_forged.mp4         both films side by side, and how the fringes move in each (or the .png next to it)
  demo/report/report.html          why the true film is accepted; demo/report-forged/report.html: why the other is not
  demo/ada/preview.png             how the built badge looks
  demo/ada/badge.pdf               the page to print at 100 %; demo/ada/assembly.pdf says how to build the badge
  demo/log.txt                     all that the commands said
To paste the commands above:     source .venv/bin/activate && export MOIREID_KEYS=demo/keys
Next: print your own with  .venv/bin/print-your-badge "Your Name" --out mine  and read README.md.
END
