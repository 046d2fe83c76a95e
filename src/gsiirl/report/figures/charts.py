"""Charts that answer to the pointer: the same panels as a drawing has, as a page shows them where it can."""

from dataclasses import dataclass, field


@dataclass(frozen=True)
class Key:
    """An entry of the legend."""

    label: str
    colour: str
    line: str = "solid"
    """The style of the line, in the words of CSS."""


@dataclass(frozen=True)
class Chart:
    """One panel."""

    title: str
    meaning: str
    """A line under the title; may be empty."""
    specification: str
    """The chart in Vega-Lite's JSON; it shows what its parameter `runs` lists, and `seeds` where there are any."""


@dataclass(frozen=True)
class Charts:
    """The panels of a figure, and what can be switched on and off in all of them."""

    panels: list[Chart]
    runs: list[Key]
    """The runs, or the curves of a figure that is not about runs."""
    levels: list[Key] = field(default_factory=list)
    seeds: list[int] = field(default_factory=list)
    """None where curves are not averages over seeds that can be switched."""
