"""Made surfaces: skewness, kurtosis and spectrum as obtained, and the waves that a width holds."""

from __future__ import annotations

from acoustics.numbers import rounded
from rolling.check import cost, refusals
from rolling.check.finding import Finding
from rolling.scene.laws import HeightLaw, SelfAffineLaw
from rolling.scene.scene import Scene
from rolling.surface.made import MadeHeights
from rolling.surface.scene_surface import scene_surface

OFF = 0.005  # difference of skewness or kurtosis that is named
ROLLOFF_WAVES = 4.0  # of the roll-off that a period should hold


def findings(scene: Scene) -> list[Finding]:
    """Judge heights that are not Gaussian or self-affine, which are made for that."""
    is_reported = any(law.is_reported for law in scene.laws)
    if not is_reported or refusals.excess([scene], 1, None):
        return []
    whole, ball = scene_surface(scene), scene.sphere.surface
    parts = [("", scene.surface.law, whole.made)]
    if ball is not None:
        parts.append(("sphere ", ball.law, whole.ball_made))
    result = []
    for name, law, heights in parts:
        if law is not None and heights is not None:
            result += [*_moments(name, law, heights), _spectrum(name, heights)]
        if isinstance(law, SelfAffineLaw):
            result.append(_rolloff(scene, law))
    return result


def _moments(name: str, law: HeightLaw, heights: MadeHeights) -> list[Finding]:
    """Compare skewness and kurtosis with the requested ones."""
    if law.is_gaussian:
        return []
    got = heights.skewness, heights.kurtosis
    texts = [rounded(value, 4) for value in (*got, *law.moments)]
    value, warning = "{} and {} of {} and {}".format(*texts), None
    if max(abs(a - b) for a, b in zip(got, law.moments, strict=True)) > OFF:
        warning = (
            "requested are {2} and {3}, and no heights nearer than {0} and {1} are found whose"
            " waves have the amplitudes of the law: choose a nearer pair, or a longer or wider"
            " surface with more asperities"
        ).format(*texts)
    key = "surface_made" if not name else "ball_surface_made"
    return [Finding(key, f"{name}skewness and kurtosis", value, warning)]


def _spectrum(name: str, heights: MadeHeights) -> Finding:
    """State the error of the spectrum in the octave where it most exceeds its scatter by chance."""
    errors, chances = heights.spectrum_error_db, heights.spectrum_chance_db
    largest = max(errors, key=lambda octave: abs(errors[octave]) / max(chances[octave], 0.1))
    value = (
        f"at most {errors[largest]:+.1f} dB at {largest} um, where chance makes"
        f" {chances[largest]:.1f} dB"
    )
    key = "surface_spectrum" if not name else "ball_surface_spectrum"
    return Finding(key, f"{name}spectrum against its law, by octave", value)


def _rolloff(scene: Scene, law: SelfAffineLaw) -> Finding:
    """Count the waves of the roll-off in the shorter period of the surface."""
    waves, warning = cost.shortest_period(scene) / (law.rolloff_um * 1e-6), None
    if waves < ROLLOFF_WAVES:
        warning = (
            f"so few waves of the roll-off make up no plateau, {ROLLOFF_WAVES:g} are wanted: choose"
            f" a surface.width_um and a track of at least {ROLLOFF_WAVES * law.rolloff_um:g} um"
        )
    return Finding("rolloff_waves", "roll-off waves in a period", rounded(waves, 3), warning)
