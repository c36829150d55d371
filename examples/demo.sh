#!/usr/bin/env bash
# From a name to three verdicts: what `make demo` runs.  Everything lands in ./demo; each command is shown.
set -euo pipefail
cd "$(dirname "$0")/.."
registry=sqlite:///demo/people.sqlite3
# The authority's key stays with the demo, apart from any that signs real badges.
export MOIREID_KEYS=demo/keys
mkdir -p demo

# Runs a command, shows it, and stops the demo unless it ends with the exit code that it should.
expect() {
    local wanted=$1 got=0
    shift
    printf '\n$ %s\n' "$(printf '%q ' "$@")"
    "$@" || got=$?
    if [ "$got" -ne "$wanted" ]; then
        echo "demo: that should have ended with exit code $wanted, but it was $got" >&2
        exit 1
    fi
}

echo "== Print a badge for each of two people, with a mount for each"
expect 0 print-your-badge "Ada Lovelace" --out demo/ada --overwrite
expect 0 print-your-badge "Grace Hopper" --out demo/grace --overwrite
echo "== Enter both into a registry"
expect 0 moireid enroll demo/ada/badge.json --registry "$registry"
expect 0 moireid enroll demo/grace/badge.json --registry "$registry"
echo "== Film Ada's badge with a hand-held phone, simulated; and once with fringes that wander by themselves"
expect 0 moireid simulate demo/ada/badge.json --out demo/ada.mp4 --distance 1.0 --frames 210 --fps 30 --overwrite
expect 0 moireid simulate demo/ada/badge.json --out demo/forged.mp4 --distance 1.0 --frames 210 --fps 30 \
    --forge randomwalk --overwrite
echo "== Is it Ada?  Accepted (exit code 0)"
expect 0 moireid verify demo/ada.mp4 --claim "Ada Lovelace" --registry "$registry" --report demo/report --overwrite
echo "== Is it Grace?  Rejected (exit code 1)"
expect 1 moireid verify demo/ada.mp4 --claim "Grace Hopper" --registry "$registry"
echo "== Is the forged film Ada?  Rejected (exit code 1)"
expect 1 moireid verify demo/forged.mp4 --claim "Ada Lovelace" --registry "$registry" --report demo/report-forged --overwrite

cat <<END

Done.  Look at:
  the page to print      demo/ada/badge.pdf        (print at 100 %; assembly.pdf says how to build it)
  how it will look       demo/ada/preview.png
  the mount              demo/ada/mount.stl        (and mount.step, mount.3mf; acrylic.dxf and .svg to laser-cut; stack.glb to look at)
  the film               demo/ada.mp4              (its truth: demo/ada.mp4.truth.csv)
  the report             demo/report/report.html   (the forged film's: demo/report-forged/report.html)
END
