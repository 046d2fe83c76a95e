"""Where and how long a run ran, as `environment.json` holds it."""

from dataclasses import dataclass, field


@dataclass(frozen=True)
class Environment:
    """The versions, the device, and the wall time of the run, or of its last part where it was gone on with."""

    wall_seconds: float
    gsiirl: str = ""
    python: str = ""
    platform: str = ""
    packages: dict[str, str] = field(default_factory=dict[str, str])
    """Versions by name."""
    device: str = ""
    resumed: bool = False
    finished: str = ""
    """When the run ended: 2026-01-31T12:00:00+00:00."""

    def __post_init__(self) -> None:
        if self.wall_seconds < 0:
            raise ValueError("wall_seconds is below 0")
