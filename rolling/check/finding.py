"""A finding of the check: a quantity of a run and its value, before the run."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Finding:
    """A row of the check: a quantity of a run and its value.

    Attributes
    ----------
    key : str
        Name for programs, which never changes with the wording. A doubt of this key marks the row.
    quantity, value : str
        Quantity and its value with unit, in words.
    seconds : float, s
        Time of computing on one core, which the runs of a sweep add up.

    Examples
    --------
    >>> import rolling
    >>> steps = rolling.read_scene("quickstart").with_(load_n=20).check()[0]
    >>> steps.quantity, steps.value
    ('steps', '6500 of 2 um')
    """

    key: str
    quantity: str
    value: str
    seconds: float = 0.0
