"""Doubts about a level before its run: the bound that a release is, and the error of its grid."""

from collections.abc import Iterable, Iterator
from dataclasses import replace
from typing import NamedTuple

from rolling.check import error_cost, resolution
from rolling.numbers.doubt import Doubt, Severity
from rolling.numbers.quantity import RELEASED_POWER, VIBRATION, Quantity
from rolling.scene.scene import Scene

# Keys of the doubts that stand beside every level of a release, and are no warnings.
SOURCES = ("upper_bound", "assumed_q", "fixed_gain")


def of_source(scene: Scene) -> Iterator[Doubt]:
    """Yield the bound or the assumption that a level of the release is.

    That a released power with q = 1 is an upper bound is a property of this number, which stands
    beside it wherever it is shown, and no doubt about it. A q or a gain that the scene chooses is
    an assumption, whose error nobody knows.
    """
    sound = scene.sound
    if sound.source == "vibration":
        return
    if sound.gain_pa_per_w_m2 is not None:
        yield Doubt(
            "fixed_gain",
            "the gain of the scene decides the level",
            Severity.INDICATIVE,
            advice=f"every level but the steady one follows from {sound.gain_pa_per_w_m2:g} Pa per "
            "W/m²",
            about=(RELEASED_POWER,),
        )
    elif sound.q != 1:
        yield Doubt(
            "assumed_q",
            f"the radiated share q = {sound.q:g} is an assumption",
            Severity.INDICATIVE,
            advice=f"levels are those of the released power times {sound.q:g}",
            about=(RELEASED_POWER,),
        )
    else:
        # 26 to 70 dB: on the 71 runs of docs/limitations.md.
        yield Doubt(
            "upper_bound",
            "a level of the released power (q = 1) is an upper bound",
            Severity.NOTE,
            advice="all released energy counts as radiated, 26 to 70 dB above the vibration "
            "(71 runs), and more at low speed",
            about=(RELEASED_POWER,),
        )


def of_grid(scene: Scene) -> Iterator[Doubt]:
    """Yield the error of the grid, unless an error estimate will tell it."""
    if not _will_be_measured(scene):
        reason = error_cost.too_short(scene) if scene.numerics.error_estimate else None
        yield resolution.grid_of_level(scene, reason)


class Forecasts(NamedTuple):
    """The two numbers of a run before it: their origin, and the doubts that are left at best."""

    vibration: Quantity
    released_power: Quantity

    @property
    def leading(self) -> Quantity:
        """The vibration, or the released power of a run that will have no vibration."""
        return self.vibration if self.vibration.coming is not None else self.released_power


def forecasts(scene: Scene, doubts: Iterable[Doubt]) -> Forecasts:
    """Return the two numbers of a run with the doubts that a check finds about them."""
    left = list(doubts)
    if _will_be_measured(scene):
        left = [doubt for doubt in left if doubt.key not in resolution.GRID_RULES]
    vibration = Quantity(VIBRATION, None, unit="dB(A)", how="forecast", coming="computed")
    of_vibration = [doubt for doubt in left if _is_of_vibration(scene, doubt)]
    if scene.dynamics is None:
        vibration = replace(vibration, coming="estimated")
        text = "a linear chain will estimate it"
        of_vibration.append(
            Doubt("vibration_estimate", text, Severity.INDICATIVE, about=(VIBRATION,))
        )
    elif scene.sound.source == "release":
        of_vibration.append(replace(resolution.grid_of_silent_vibration(), about=(VIBRATION,)))
    if scene.is_silent:
        reason = "a smooth surface is silent"
        vibration = replace(vibration, coming=None, reason=reason)
    released = Quantity(RELEASED_POWER, None, unit="dB(A)", how="forecast", coming="upper bound")
    if scene.sound.gain_pa_per_w_m2 is not None or scene.sound.q != 1:
        released = replace(released, coming="assumed")
    return Forecasts(vibration.with_doubts(of_vibration), released.with_doubts(left))


def _is_of_vibration(scene: Scene, doubt: Doubt) -> bool:
    """Tell whether a doubt of the check touches the vibration.

    The grid's error of the level is that of the record that is measured.
    """
    is_of_grid = doubt.key == resolution.LEVEL_KEY
    return not (is_of_grid and scene.sound.source == "release")


def _will_be_measured(scene: Scene) -> bool:
    """Tell whether an error estimate will measure the error of the grid."""
    return scene.numerics.error_estimate and not error_cost.too_short(scene)
