"""A doubt about the numbers of a run, before it or after it, and how severe it is."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

# errors up to which a level is trusted, or indicative
TRUSTED_DB = 1.0
INDICATIVE_DB = 3.0


class Severity(IntEnum):
    """What a doubt leaves of a level, from a note to a scene that does not run."""

    NOTE = 0  # a standing property of the numbers
    TRUST = 1  # a small known error, or a limit that hardly touches the level
    INDICATIVE = 2
    DO_NOT_QUOTE = 3
    REFUSED = 4  # the scene does not run, or its contact has no solution

    @property
    def word(self) -> str:
        """The severity in words, as summary.json has it."""
        return self.name.lower().replace("_", " ")


@dataclass(frozen=True)
class Doubt:
    """A reason to trust a number less.

    Attributes
    ----------
    key : str
        Name for programs, which never changes with the wording.
    text : str
        What is wrong, with its number.
    severity : Severity
        What the doubt leaves of a level.
    decibels : float or None, dB
        Size of the error; None: unknown.
    advice : str
        What follows from it, and what to do. Default: nothing.
    about : tuple of str
        Names of the quantities that it touches, such as `vibration`. Default: all.

    Examples
    --------
    >>> import rolling
    >>> check = rolling.read_scene("quickstart").with_(load_n=20).check()
    >>> doubts = {doubt.key: doubt for doubt in check.doubts["quickstart"]}
    >>> doubts["upper_bound"].text, doubts["upper_bound"].severity.word
    ('a level of the released power (q = 1) is an upper bound', 'note')
    """

    key: str
    text: str
    severity: Severity
    decibels: float | None = None
    advice: str = ""
    about: tuple[str, ...] = ()

    def touches(self, quantity: str) -> bool:
        """Tell whether it is a doubt about the quantity of a name."""
        return not self.about or quantity in self.about

    @property
    def line(self) -> str:
        """Text and advice, as a person reads them."""
        return f"{self.text}: {self.advice}" if self.advice else self.text

    @property
    def rank(self) -> tuple[Severity, float]:
        """Order of doubts: severity first, then decibels."""
        return self.severity, self.decibels or 0.0


def severity_of(decibels: float) -> Severity:
    """Return the severity of an error of a level [dB]."""
    if abs(decibels) > INDICATIVE_DB:
        return Severity.DO_NOT_QUOTE
    if abs(decibels) > TRUSTED_DB:
        return Severity.INDICATIVE
    return Severity.TRUST


def sized(
    key: str,
    text: str,
    decibels: float,
    advice: str = "",
    least: Severity = Severity.TRUST,
) -> Doubt:
    """Return a doubt of known decibels, which decide its severity; it is `least` or worse."""
    size = abs(decibels)
    return Doubt(key, text, max(severity_of(size), least), size, advice)
