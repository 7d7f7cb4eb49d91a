"""Line of the check and the words for its numbers."""

import string
from dataclasses import dataclass
from typing import Any

from acoustics.numbers import clock, micrometres, rounded, rounded_down, rounded_up, si
from rolling.check import cost
from rolling.scene.messages import table
from rolling.scene.scene import Scene

SURFACE = "surface_time"  # key of the finding whose time runs with the same surface share
MIN_SECONDS = 1.0  # shorter times for making a surface are not listed
_UNITS = ("m", "s", "Hz", "Pa", "N")


_FINDINGS: dict[str, dict[str, str]] = table("rolling.check", "findings")


@dataclass(frozen=True)
class Finding:
    """One line of the check.

    Attributes
    ----------
    key : str
        Name for programs, which never changes with the wording.
    quantity, value : str
        Quantity and its value with unit, in words.
    warning : str or None
        Doubtful number, and the advice to change it.
    seconds : float, s
        Time of computing on one core, which the runs of a sweep add up.

    Examples
    --------
    >>> import rolling
    >>> steps = rolling.read_scene("quickstart").with_(load_n=20).check()[0]
    >>> steps.quantity, steps.value
    ('steps', '25000 of 2 um')
    """

    key: str
    quantity: str
    value: str
    warning: str | None = None
    seconds: float = 0.0


class _Words(string.Formatter):
    """Formatter of numbers with units and digits."""

    def format_field(self, value: Any, spec: str) -> str:
        """Write a number with a unit, with a number of digits, rounded up or down, or as usual."""
        if spec in _UNITS:
            return si(value, spec)
        if spec == "up":
            return rounded_up(value)
        if spec == "down":
            return rounded_down(value)
        if spec == "um":
            return micrometres(value)
        return rounded(value, int(spec)) if spec.isdecimal() else format(value, spec)


def written(text: str, /, **numbers: object) -> str:
    """Write numbers into the braces of a text: with a unit, so many digits, or as usual."""
    return _Words().format(text, **numbers)


def sentence(key: str, variant: str, /, **numbers: object) -> str:
    """Write a sentence of a finding in findings.toml with its numbers."""
    return written(_FINDINGS[key][variant], **numbers)


def judged(key: str, value: str, doubt: bool | str, /, **numbers: object) -> Finding:
    """Return a finding of findings.toml; in doubt it has its warning, or a variant of it."""
    variant = doubt if isinstance(doubt, str) else "warning"
    warning = sentence(key, variant, **numbers) if doubt else None
    return Finding(key, sentence(key, "name", **numbers), value, warning)


def computing(core_seconds: float) -> str:
    """Write the time that a computation of one core [s] takes on all cores."""
    cores = cost.cores()
    return f"about {clock(core_seconds / cores)} on {cores} core{'s' * (cores > 1)}"


def surface_time(scene: Scene, slow: float = 1.0) -> list[Finding]:
    """State the time to make a random surface, which every process does; nothing if it is short.

    `slow` is the time that this machine took over the expected one.
    """
    seconds = slow * cost.cores() * sum(cost.surface_seconds(scene))
    if seconds < MIN_SECONDS:
        return []
    value = f"{computing(seconds)}, each of which makes it"
    return [Finding(SURFACE, "making of the surface", value, None, seconds)]
