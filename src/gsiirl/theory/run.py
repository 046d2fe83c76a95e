"""Running the checks one after another; what each found is on the disk before the next begins."""

import importlib
import importlib.metadata
import multiprocessing
import platform
import time
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path

import jax
from rich.console import Console
from rich.table import Table
from rich.text import Text

from gsiirl._version import __version__
from gsiirl.program.progress import shown
from gsiirl.runs.files.atomic import refuse_unwritable
from gsiirl.runs.findings import Finding, Findings
from gsiirl.runs.measurement_words import bound_in_words, value_in_words


@dataclass(frozen=True)
class Check:
    """A module whose function `check(quick)` returns a Finding, or a list of them."""

    module: str
    title: str
    timed: bool = False
    """Whether it measures times of programs, which must then be compiled as they are in use."""
    beside: bool = False
    """Whether it runs, in the quick mode, in a process beside the others: compilation leaves a second core idle."""

    def run(self, quick: bool) -> list[Finding]:
        """What it finds, with the seconds that took; several findings share them evenly."""
        began = time.perf_counter()
        found = importlib.import_module(self.module).check(quick)
        findings = [found] if isinstance(found, Finding) else list(found)
        seconds = (time.perf_counter() - began) / len(findings)
        return [replace(finding, seconds=seconds, check=self.title) for finding in findings]


CHECKS = (
    Check("gsiirl.theory.checks.lemma_1_and_3", "Lemmas 1 and 3"),
    Check("gsiirl.theory.checks.lemma_2", "Lemma 2", beside=True),
    Check("gsiirl.theory.checks.quadratic", "Quadratic problem"),
    Check("gsiirl.theory.checks.lemma_6", "Lemma 6"),
    Check("gsiirl.theory.checks.theorem_1", "Theorem 1", timed=True),
    Check("gsiirl.theory.checks.theorem_2", "Theorem 2", beside=True),
    Check("gsiirl.theory.checks.corollary_2_1", "Corollary 2.1"),
)


def run_checks(out: Path, quick: bool, earlier: Findings | None, quiet: bool = False) -> Findings:
    """Run the checks that are not among the `earlier` findings and write `theory.json` after each.

    Raises:
        InputError: `out` cannot be written.
    """
    # In the checks' order, also where an earlier version of the list had another.
    known = {
        check.title: [each for each in (earlier.findings if earlier else []) if each.check == check.title]
        for check in CHECKS
    }
    findings = Findings(quick, [], _environment())
    findings = _write(findings, known, out)
    # Quick checks call each program a few times only: most of the compiler's work would not pay.
    with shown(quiet) as progress, jax.enable_x64(True), _compiled_carelessly(True) if quick else nullcontext():
        bar = progress.add_task("", total=len(CHECKS), completed=len(CHECKS) - len(findings.missing))
        with ProcessPoolExecutor(1, multiprocessing.get_context("spawn")) as process:
            awaited = {
                check.title: process.submit(_run_carelessly, check)
                for check in CHECKS
                if quick and check.beside and not known[check.title]
            }
            # What runs in the other process is asked for last.
            for check in sorted(CHECKS, key=lambda each: each.title in awaited):
                heading = f"{CHECKS.index(check) + 1}/{len(CHECKS)} {check.title}"
                if known[check.title]:
                    progress.console.print(f"{heading}: kept from the earlier call", highlight=False)
                    continue
                progress.update(bar, description=heading)
                if check.title in awaited:
                    known[check.title] = awaited[check.title].result()
                else:
                    with _compiled_carelessly(False) if quick and check.timed else nullcontext():
                        known[check.title] = check.run(quick)
                findings = _write(findings, known, out)
                for finding in known[check.title]:
                    _print_finding(progress.console, heading, finding)
                progress.advance(bar)
        progress.update(bar, description="all checks")
    return findings


def _run_carelessly(check: Check) -> list[Finding]:
    with jax.enable_x64(True), _compiled_carelessly(True):
        return check.run(True)


def _write(findings: Findings, known: dict[str, list[Finding]], out: Path) -> Findings:
    findings = replace(
        findings,
        findings=[finding for found in known.values() for finding in found],
        missing=[title for title, found in known.items() if not found],
    )
    with refuse_unwritable("--out", out, "make room or allow it: the same command goes on"):
        findings.write(out)
    return findings


@contextmanager
def _compiled_carelessly(carelessly: bool) -> Iterator[None]:
    """Leave out most of the compiler's work, or do leave it in."""
    before = jax.config.read("jax_disable_most_optimizations")
    if carelessly != before:
        # What was compiled the other way is not to be called.
        jax.clear_caches()
    jax.config.update("jax_disable_most_optimizations", carelessly)
    try:
        yield
    finally:
        jax.config.update("jax_disable_most_optimizations", before)


def _print_finding(console: Console, heading: str, finding: Finding) -> None:
    table = Table(box=None, show_header=False, padding=(0, 2, 0, 0), pad_edge=False)
    table.add_column(overflow="fold")
    for _ in range(2):
        table.add_column(justify="right")
    table.add_column()
    for each in finding.measurements:
        verdict = {True: Text("holds", "green"), False: Text("MISSED", "bold red"), None: Text("")}[each.holds]
        table.add_row(Text(f"  {each.name}"), value_in_words(each), bound_in_words(each), verdict)
    console.print(Text(f"{heading}: {finding.title} ({finding.seconds:.1f} s)", "bold"))
    console.print(table)


def _environment() -> dict[str, str]:
    return {
        "gsiirl": __version__,
        "python": platform.python_version(),
        "platform": platform.platform(),
        "jax": importlib.metadata.version("jax"),
        "device": str(jax.devices()[0]),
        "date": datetime.now(UTC).date().isoformat(),
    }
