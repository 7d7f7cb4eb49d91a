"""Made surfaces: skewness, kurtosis and spectrum as obtained, and the waves that a width holds."""

from __future__ import annotations

from typing import Any

from acoustics.numbers import rounded
from rolling.check import cost, refusals
from rolling.check.finding import Finding
from rolling.scene.laws import HeightLaw, SelfAffineLaw
from rolling.scene.scene import Scene
from rolling.surface.made import is_described
from rolling.surface.scene_surface import scene_surface

OFF = 0.005  # difference of skewness or kurtosis that is named
ROLLOFF_WAVES = 4.0  # of the roll-off that a period should hold


def findings(scene: Scene) -> list[Finding]:
    """Judge heights that are self-affine or not Gaussian; they are made for that."""
    laws = [law for law in scene.laws if is_described(law)]
    if not laws or refusals.excess([scene], 1, None):
        return []
    made = scene_surface(scene).made
    result = []
    for law, (key, heights) in zip(laws, made.items(), strict=True):
        name = "sphere " * key.startswith("ball")
        if not law.is_gaussian:
            result.append(_moments(key, name, law, heights))
        errors, chances = heights["spectrum_error_db"], heights["spectrum_chance_db"]
        largest = max(errors, key=lambda octave: abs(errors[octave]) / max(chances[octave], 0.1))
        value = f"at most {errors[largest]:+.1f} dB at {largest} um"
        value += f", where chance makes {chances[largest]:.1f} dB"
        quantity, warning = f"{name}spectrum against its law, by octave", _few_waves(scene, law)
        result.append(Finding(f"{key}_spectrum", quantity, value, warning))
    return result


def _moments(key: str, name: str, law: HeightLaw, heights: dict[str, Any]) -> Finding:
    """Compare skewness and kurtosis with the requested values."""
    got = heights["skewness"], heights["kurtosis"]
    texts = [rounded(value, 4) for value in (*got, *law.moments)]
    value, warning = "{} and {}, requested {} and {}".format(*texts), None
    if max(abs(a - b) for a, b in zip(got, law.moments, strict=True)) > OFF:
        warning = (
            f"{value}: nothing nearer is found with the spectrum of the law; choose a nearer pair,"
            " or a longer or wider surface with more asperities"
        )
    return Finding(key, f"{name}skewness and kurtosis", value, warning)


def _few_waves(scene: Scene, law: HeightLaw) -> str | None:
    """Warn of a roll-off of few waves in the shorter period of the surface."""
    least_um = ROLLOFF_WAVES * law.rolloff_um if isinstance(law, SelfAffineLaw) else 0.0
    if cost.shortest_period(scene) * 1e6 >= least_um:
        return None
    words = f"{ROLLOFF_WAVES:g} waves of the roll-off or more make up a plateau: choose"
    return f"{words} a surface.width_um and a track of at least {least_um:g} um"
