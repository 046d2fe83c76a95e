"""The command `gsiirl theory`. `gsiirl.cli` imports this module only when it is asked for, and JAX later still."""

import sys
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from gsiirl.program.command import command


def theory(
    *,
    quick: Annotated[
        bool,
        Parameter(
            negative="",
            help="Fewer games, points and combinations, in a few minutes; the same claims and the same bounds.",
        ),
    ] = False,
    out: Annotated[
        Path,
        Parameter(
            metavar="DIR",
            help="Folder for theory.json, index.html and the figures: a new or empty one, or that of an earlier call, "
            "whose finished checks are kept: after an interruption only the missing ones are run.",
        ),
    ],
    quiet: Annotated[bool, Parameter(negative="", help="Show no progress.")] = False,
) -> int:
    """Measure each lemma and theorem; the exit status is 1 when a measurement misses a bound that the claim sets it."""
    from gsiirl.theory.folder import earlier_findings

    earlier = earlier_findings(out, quick)
    # Only now, so that bad input is answered at once.
    from gsiirl.report import write_theory_page
    from gsiirl.theory.run import run_checks

    try:
        findings = run_checks(out, quick, earlier, quiet)
        page = write_theory_page(findings, out)
    except KeyboardInterrupt:
        again = command("theory", *(["--quick"] if quick else []), "--out", out)
        raise KeyboardInterrupt(f"finished checks are kept; go on with `{again}`") from None
    print(page)
    missed = [f"{finding.title}, {measurement.name}" for finding, measurement in findings.missed]
    if missed:
        print(f"gsiirl: missed {len(missed)} of the bounds: {'; '.join(missed)}", file=sys.stderr)
    return 1 if missed else 0
