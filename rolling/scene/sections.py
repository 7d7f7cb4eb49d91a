"""Rolling, numerics, recovery, dynamics and sound: sections with units in the names of their keys.

Lengths are in mm or um and moduli in GPa here; the properties of `Scene` are SI.
"""

from __future__ import annotations

import math
from typing import Annotated, Any, Literal

import pydantic
from pydantic import AfterValidator, BeforeValidator, Field, model_validator

from acoustics.numbers import rounded
from rolling.scene import messages
from rolling.scene.messages import fault, is_number, numbers, plain_number, quoted
from rolling.scene.models import Section
from rolling.scene.track import Motion

# ---- rolling


WEIGHT: Literal["weight"] = "weight"
MAX_PASSES = 100  # plastic work falls by half or more from pass to pass
SPEED = "a number > 0, or at least two [time_s, speed_m_s] pairs"


def _speed(value: Any) -> Any:
    """Return a speed, or pairs as tuples."""
    if is_number(value) and value > 0:
        return float(value)
    pairs: list[Any] = (
        [numbers(pair, 2) for pair in value] if isinstance(value, list | tuple) else []
    )
    if len(pairs) < 2 or None in pairs:
        raise fault(f"got {quoted(value)}, allowed: {SPEED}", at="rolling.speed_m_s")
    try:
        Motion.of(pairs)
    except ValueError as error:
        raise fault(f"got {quoted(value)}: {error}", at="rolling.speed_m_s") from error
    return tuple(pairs)


_Pair = tuple[Annotated[float, Field(ge=0)], Annotated[float, Field(ge=0)]]
Speed = Annotated[
    Annotated[float, Field(gt=0)] | Annotated[tuple[_Pair, ...], Field(min_length=2)],
    BeforeValidator(_speed),
]


LOAD = f"greater than 0, or {WEIGHT}"


def number_or(
    word: str, allowed: str, sizes: messages.Plausible | None = None, **limits: float
) -> tuple[BeforeValidator, pydantic.WithJsonSchema]:
    """Return validator and schema of a word, or of a number within limits of JSON Schema."""
    if sizes is not None:
        limits = {"minimum": sizes.least, "maximum": sizes.most}
    above = limits.get("exclusiveMinimum", -math.inf)
    least, most = limits.get("minimum", -math.inf), limits.get("maximum", math.inf)

    def chosen(value: Any) -> Any:
        if isinstance(value, str) and value == word:
            return value
        if is_number(value):
            if value > above and least <= value <= most:
                return float(value)
            if sizes is not None:
                raise fault(messages.implausible(value, sizes))
        raise fault(f"got {quoted(value)}, allowed: {allowed}")

    kinds = [{"type": "number", **limits}, {"type": "string", "const": word}]
    return BeforeValidator(chosen), pydantic.WithJsonSchema({"anyOf": kinds})


Load = Annotated[float | Literal["weight"], *number_or(WEIGHT, LOAD, exclusiveMinimum=0)]


class Rolling(Section):
    """Load, speed and duration of the rolling.

    Attributes
    ----------
    load_n : float or "weight"
        Normal load [N]; weight: that of the sphere, which needs sphere.density_kg_m3
    speed_m_s : float or pairs of float
        Speed [m/s], or [time [s], speed [m/s]] pairs: times increasing from 0, linear between them,
        constant after the last
    resistance : float, optional
        Coefficient of rolling resistance c [-] of a free solid sphere, which slows down by 5/7 c
        load/mass; absent: the speed is kept
    drop_mm : float, optional
        Height of the fall [mm] at the start; needs dynamics and the sound of the vibration
    duration_s : float, optional
        Time rolled [s]; absent with distance_mm, with resistance (until the sphere rests) and with
        a height file (once round it)
    distance_mm : float, optional
        Distance rolled [mm] instead of a duration, so that every speed meets the same surface
    start_um : float
        Start position along the track [um]
    passes : int, optional
        Passes [-] over the track, each on the surface that the pass before left; the record is the
        last; more than 1 needs plate.plasticity: permanent

    Examples
    --------
    >>> import rolling
    >>> rolling.Rolling(load_n=20, speed_m_s=[[0, 0.1], [1, 0.3]], duration_s=1).start_um
    0.0
    """

    load_n: Load = WEIGHT
    speed_m_s: Speed
    resistance: float | None = Field(default=None, ge=0, le=1)
    drop_mm: float | None = Field(default=None, gt=0)
    duration_s: float | None = Field(default=None, gt=0)
    distance_mm: float | None = Field(default=None, gt=0)
    start_um: float = 0.0
    passes: int | None = Field(default=None, ge=1, le=MAX_PASSES)

    @model_validator(mode="after")
    def _one_length(self) -> Rolling:
        if self.duration_s is not None and self.distance_mm is not None:
            raise fault("given beside duration_s, allowed: one of them", at="rolling.distance_mm")
        if self.resistance is not None and isinstance(self.speed_m_s, tuple):
            raise fault(
                "only goes with one speed_m_s, at which the sphere starts, not with pairs",
                at="rolling.resistance",
            )
        return self


# ---- numerics


STEP_NODES = [1 / k for k in range(16, 1, -1)] + [float(k) for k in range(1, 65)]
TOLERANCES = 1e-12, 1e-1  # allowed numbers
TOLERANCE = f"auto, or a number >= {rounded(TOLERANCES[0])} and <= {rounded(TOLERANCES[1])}"


def _step_nodes(value: float) -> float:
    """Return the allowed value that a rounded value stands for, such as a third for 0.333333."""
    closest = min(STEP_NODES, key=lambda allowed: abs(math.log(value / allowed)))
    if abs(value / closest - 1) > 1e-5:
        raise fault(
            f"got {plain_number(value)}, allowed: a whole number from 1 to 64, or one over a whole"
            f" number down to 1/16; nearest: {plain_number(closest)}",
            at="numerics.step_nodes",
        )
    return closest


Tolerance = Annotated[
    float | Literal["auto"],
    *number_or("auto", TOLERANCE, minimum=TOLERANCES[0], maximum=TOLERANCES[1]),
]


class Numerics(Section):
    """Resolution and accuracy of the solution.

    Attributes
    ----------
    step_nodes : float
        Step in nodes [-]: 1 to 64, or one over a whole number down to 1/16
    tolerance : float or "auto"
        Maximum violation of the contact conditions over the maximum deflection [-]; auto takes
        1e-4, and less for smooth surfaces
    edges : str
        Nodes at the edge of yielding patches: sharp loads them in full or not at all, blended by
        the share of their cell in contact
    subcells : int or "auto"
        Sub-cells along a cell's side, with heights and pressures of their own; auto takes 2 on
        steep surfaces that yield, with blended edges
    precision : str
        Precision of the transforms in the iteration; the check of a solution is in double precision
    error_estimate : bool
        Estimate the errors of grid and tolerance in every level, for a quarter more time, or 40 %
        under an exponential law; on a short track for up to 20 s

    Examples
    --------
    >>> import rolling
    >>> rolling.Numerics(step_nodes=2).tolerance
    'auto'
    """

    step_nodes: Annotated[float, AfterValidator(_step_nodes)] = Field(default=1.0, gt=0)
    tolerance: Tolerance = "auto"
    edges: Literal["sharp", "blended"] = "blended"
    subcells: Literal["auto", 1, 2, 4] = "auto"
    precision: Literal["single", "double"] = "single"
    error_estimate: bool = False


# ---- recovery, dynamics, sound


class Recovery(Section):
    """Recovery of the nodes that leave the contact.

    Attributes
    ----------
    events : bool
        Write a table of recovery events
    rule : str
        Pressure of a falling node: mean of both ends of the step, or left_end, the article's

    Examples
    --------
    >>> import rolling
    >>> rolling.Recovery(events=True).rule
    'mean'
    """

    events: bool = False
    rule: Literal["mean", "left_end"] = "mean"


def _odd(value: int) -> int:
    """Refuse an even number of loads."""
    if value % 2 == 0:
        raise fault(f"got {value}, allowed: an odd whole number from 3 to 15")
    return value


class Dynamics(Section):
    """Vibration of the sphere on its contact and on the plate, which makes the force fluctuate.

    Attributes
    ----------
    loads : int
        Minimum number of loads at which the track is marched [-], odd
    span : float
        Ratio of a marched load to the next lower one [-]
    release : bool, optional
        Release under the moving load, by one more march, in place of the constant load; absent:
        true for sound.source: release

    Examples
    --------
    >>> import rolling
    >>> rolling.Dynamics(loads=5).span
    1.4
    """

    loads: Annotated[int, AfterValidator(_odd)] = Field(default=3, ge=3, le=15)
    span: float = Field(default=1.4, ge=1.05, le=4)
    release: bool | None = None


MAX_LISTENERS = 16
_PLACES = f"[x, y, z], three numbers in mm, or a list of 1 to {MAX_LISTENERS} such places"


def _listeners(value: Any) -> Any:
    """Return listeners as tuples."""
    places = [value] if numbers(value, 3) else value if isinstance(value, list | tuple) else []
    valid = [place for place in (numbers(place, 3) for place in places) if place is not None]
    if not 0 < len(places) == len(valid) <= MAX_LISTENERS:
        got = f"{len(valid)} places" if len(valid) > MAX_LISTENERS else quoted(value)
        raise fault(f"got {got}, allowed: {_PLACES}")
    if any(place[2] == 0 for place in valid):
        raise fault(f"got {quoted(value)}, allowed: z above 0, on the ball's side, or below 0")
    return tuple(valid)


_PLACE = {"type": "array", "minItems": 3, "maxItems": 3, "items": {"type": "number"}}
_PLACE_LIST = {"type": "array", "minItems": 1, "maxItems": MAX_LISTENERS, "items": _PLACE}
Listeners = Annotated[
    tuple[tuple[float, float, float], ...],
    *(BeforeValidator(_listeners), pydantic.WithJsonSchema({"anyOf": [_PLACE, _PLACE_LIST]})),
]


class Sound(Section):
    """Source, listener, and conversion of release power to sound pressure.

    Attributes
    ----------
    source : str, optional
        Origin of the sound: release of elastic energy (an upper bound), or vibration of sphere and
        plate, which needs dynamics; absent: vibration with dynamics, otherwise release
    ball : bool
        Hear the vibration of the sphere beside the plate's
    distance_m : float
        Distance of the listener [m], more than the sphere's radius; beside listener_mm the radius
        of the half sphere of the mean level
    listener_mm : three floats, or a list of them, optional
        Listeners (x, y, z) [mm] of a plate with edges, from the corner of contact_mm, z on the
        ball's side; the first has the main levels, two make stereo; absent: at distance_m above the
        contact, or the middle of its path
    q : float
        Share of the released energy that is radiated [-]
    gain_pa_per_w_m2 : float, optional
        Fixed factor from intensity to sound pressure [Pa per W/m2]; absent: energy-true per run
    listen_s : float, optional
        Length [s] of listen.wav as a long record, beyond the solved track; absent: laps of the
        record, at least 5 s
    loudness : bool
        Report loudness (ISO 532-1) and sharpness (DIN 45692), or N5 and the maximum of the loudness
        in time where the sound is not steady; needs the package mosqito

    Examples
    --------
    >>> import rolling
    >>> rolling.Sound(distance_m=0.5, listen_s=10).q
    1.0
    """

    source: Literal["release", "vibration"] | None = None
    ball: bool = True
    distance_m: float = Field(default=1.0, gt=0)
    listener_mm: Listeners | None = None
    q: float = Field(default=1.0, gt=0, le=1)
    gain_pa_per_w_m2: float | None = Field(default=None, gt=0)
    listen_s: float | None = Field(default=None, ge=0.1, le=120)
    loudness: bool = False

    @model_validator(mode="after")
    def _with_free_factors(self) -> Sound:
        refuse_free_factors(self)
        return self


def refuse_free_factors(sound: Sound) -> None:
    """Refuse the free factors of the release for a vibration, whose pressure has none."""
    for key, default in (("q", 1), ("gain_pa_per_w_m2", None)):
        value = getattr(sound, key)
        if sound.source == "vibration" and value != default:
            raise fault(
                f"got {plain_number(value)}, which only goes with source: release; the pressure of"
                " the vibration has no free factor",
                at=f"sound.{key}",
            )
