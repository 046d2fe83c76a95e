#!/bin/sh
# Three algorithms on one network, 3 seeds each, then the report. What is finished stays, what was interrupted goes on.
# Usage: scripts/demo.sh [GSIIRL]     from the repository's root; GSIIRL is the program to run
set -eu
gsiirl=${1:-gsiirl}
out=runs/demo

for algorithm in gsiirl ma-irl marl; do
    run=$out/$algorithm
    if [ -f "$run/config.json" ]; then
        "$gsiirl" resume "$run"
    else
        "$gsiirl" run security --graph small-linear --algorithm "$algorithm" --seeds 3 --out "$run"
    fi
done

"$gsiirl" report "$out/gsiirl" "$out/ma-irl" "$out/marl" --out "$out/report" > /dev/null
echo "Open $out/report/index.html in a browser."
