"""Made heights: skewness, kurtosis and spectrum as obtained, and the waves that a period holds."""

from __future__ import annotations

from dataclasses import replace

from rolling.check import cost, refusals
from rolling.check.finding import Finding, judged, sentence
from rolling.scene.laws import SelfAffineLaw
from rolling.scene.scene import Scene
from rolling.surface.made import is_described
from rolling.surface.scene_surface import scene_surface

OFF = 0.005  # difference of skewness or kurtosis that is named
ROLLOFF_WAVES = 4.0  # of the roll-off that a period should hold


def findings(scene: Scene) -> list[Finding]:
    """Make heights that are self-affine or not Gaussian, and judge them."""
    laws = [law for law in scene.laws if is_described(law)]
    if not laws or refusals.excess([scene], 1, None):
        return []
    result = []
    for law, (key, heights) in zip(laws, scene_surface(scene).made.items(), strict=True):
        of = "sphere " * key.startswith("ball")
        if not law.is_gaussian:
            skewness, kurtosis = heights["skewness"], heights["kurtosis"]
            wanted = {"wanted_skewness": law.moments[0], "wanted_kurtosis": law.moments[1]}
            got = {"skewness": skewness, "kurtosis": kurtosis}
            value = sentence("surface_made", "value", **got, **wanted)
            off = max(abs(skewness - law.moments[0]), abs(kurtosis - law.moments[1])) > OFF
            result.append(replace(judged("surface_made", value, off, of=of, value=value), key=key))
        errors, chances = heights["spectrum_error_db"], heights["spectrum_chance_db"]
        octave = max(errors, key=lambda name: abs(errors[name]) / max(chances[name], 0.1))
        numbers = {"octave": octave, "error": errors[octave], "chance": chances[octave]}
        value = sentence("surface_spectrum", "value", **numbers)
        least_um = ROLLOFF_WAVES * law.rolloff_um if isinstance(law, SelfAffineLaw) else 0.0
        few = cost.shortest_period(scene) * 1e6 < least_um
        words = {"of": of, "waves": ROLLOFF_WAVES, "least_um": least_um}
        spectrum = judged("surface_spectrum", value, few, **words)
        result.append(replace(spectrum, key=f"{key}_spectrum"))
    return result
