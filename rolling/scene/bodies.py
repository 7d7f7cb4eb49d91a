"""Sphere and plate of a scene, the bodies in contact."""

import math
from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import BeforeValidator, Field, WithJsonSchema, model_validator

from acoustics.numbers import rounded
from rolling.scene import library
from rolling.scene.messages import MATERIALS, fault, numbers, plain_number, quoted
from rolling.scene.models import Section
from rolling.scene.sections import number_or
from rolling.scene.surfaces import BallSurface

YOUNG, HARDNESS = MATERIALS["youngs_modulus_gpa"], MATERIALS["hardness_gpa"]
DENSITY = MATERIALS["density_kg_m3"]
Material = Annotated[str, library.listed("materials")]
MAX_OBLONG = 1e6  # one radius over the other
HARDEST = 5  # Young's modulus over hardness is above 5 in every material, and about 8 in diamond


Hardness = Annotated[
    float | Literal["none"], *number_or(library.NONE, "a finite number, or none", HARDNESS)
]


def _refuse_half(section: Section, keys: tuple[str, str], rule: str) -> None:
    """Refuse one key of a pair without the other."""
    for missing, given in (keys, keys[::-1]):
        if getattr(section, missing) is None and getattr(section, given) is not None:
            name = type(section).__name__.lower()
            raise fault(f"missing beside {given}; {rule}", at=f"{name}.{missing}")


class Sphere(Section):
    """Rolling sphere, rigid unless it has a modulus.

    Attributes
    ----------
    radius_mm : float
        Radius along the track [mm]; mass, circumference and sound follow from it
    radius_across_mm : float, optional
        Radius across the track [mm], as of a wheel or a crowned roller; absent: radius_mm
    material : str, optional
        Material, which gives Young's modulus, Poisson's ratio and density; values beside it win
    density_kg_m3 : float, optional
        Density [kg/m3]; dynamics needs it, and checks without it take 7850
    youngs_modulus_gpa : float, optional
        Young's modulus [GPa]; absent: a rigid sphere
    poissons_ratio : float, optional
        Poisson's ratio [-]; absent: a rigid sphere
    surface : section, optional
        Surface around the circumference; absent: smooth

    Examples
    --------
    >>> import rolling
    >>> rolling.Sphere(radius_mm=5, material="steel-100cr6").density_kg_m3
    7810.0
    """

    NAMED: ClassVar[str] = "sphere"

    radius_mm: float = Field(gt=0)
    radius_across_mm: float | None = Field(default=None, gt=0)
    material: Material | None = None
    density_kg_m3: float | None = Field(default=None, ge=DENSITY.least, le=DENSITY.most)
    youngs_modulus_gpa: float | None = Field(default=None, ge=YOUNG.least, le=YOUNG.most)
    poissons_ratio: float | None = Field(default=None, ge=0, le=0.5)
    surface: BallSurface | None = Field(default=None, discriminator="kind")

    @model_validator(mode="after")
    def _both_or_neither(self) -> Self:
        if self.radius_across_mm is not None:
            ratio = self.radius_across_mm / self.radius_mm
            if not 1 / MAX_OBLONG <= ratio <= MAX_OBLONG:
                least = plain_number(self.radius_mm / MAX_OBLONG)
                most = plain_number(self.radius_mm * MAX_OBLONG)
                raise fault(
                    f"got {plain_number(self.radius_across_mm)}, allowed: {least} to {most},"
                    " a millionth of radius_mm to a million times it",
                    at="sphere.radius_across_mm",
                )
        rule = "an elastic sphere needs both, a rigid sphere neither"
        _refuse_half(self, ("youngs_modulus_gpa", "poissons_ratio"), rule)
        return self


def _point(value: Any) -> Any:
    """Return a point on the plate as a tuple."""
    if (point := numbers(value, 2)) is None:
        raise fault(f"got {quoted(value)}, allowed: [x, y], two numbers in mm from a corner")
    return point


_PAIR = {"type": "array", "minItems": 2, "maxItems": 2, "items": {"type": "number"}}
Point = Annotated[tuple[float, float], BeforeValidator(_point), WithJsonSchema(_PAIR)]
# Keys of the plate that change its vibration, and not the march of the contact.
VIBRATING_PLATE = (
    *("density_kg_m3", "thickness_mm", "loss_factor", "length_mm", "width_mm"),
    *("contact_mm", "contact_path", "contact_end_mm", "contact_loss_factor"),
)
CONTACT_AT = 0.43, 0.37  # default over length and width: many modes have nodal lines in the middle


class Plate(Section):
    """Plate that the sphere rolls on, a half-space to the contact.

    Attributes
    ----------
    material : str, optional
        Material, which gives modulus, Poisson's ratio, hardness, density and, with a thickness,
        loss factor; values beside it win
    youngs_modulus_gpa : float
        Young's modulus [GPa]
    poissons_ratio : float
        Poisson's ratio [-]
    hardness_gpa : float or "none", optional
        Hardness [GPa], the maximum pressure, below a fifth of the modulus; none or absent: purely
        elastic
    yield_strength_gpa : float, optional
        Yield strength [GPa], a third of the hardness, in place of it
    plasticity : str, optional
        Memory of yielding: memoryless (default) meets the virgin surface everywhere, permanent
        keeps the plastic overlap and needs a hardness
    density_kg_m3 : float, optional
        Density [kg/m3]; dynamics needs it
    thickness_mm : float, optional
        Thickness [mm] of a plate that bends, for dynamics; absent: a half-space
    loss_factor : float, optional
        Loss factor of bending waves [-], for the sound power above coincidence; a plate with edges
        needs it
    length_mm : float, optional
        Length [mm] along x of a rectangular plate, simply supported at its edges; absent: an
        infinite plate
    width_mm : float, optional
        Width [mm] along y of a rectangular plate
    contact_mm : pair of float, optional
        Contact point (x, y) [mm] from a corner of a rectangular plate; absent: 0.43 of the length,
        0.37 of the width
    contact_path : str, optional
        Path of the contact: fixed (default) at contact_mm, or to-and-fro between contact_mm and
        contact_end_mm
    contact_end_mm : pair of float, optional
        Other end (x, y) [mm] of a path to-and-fro
    contact_loss_factor : float, optional
        Loss factor of the contact stiffness [-] at the contact resonance; absent: 0

    Examples
    --------
    >>> import rolling
    >>> rolling.Plate(material="glass", thickness_mm=8).youngs_modulus_gpa
    70.0
    """

    NAMED: ClassVar[str] = "plate"

    material: Material | None = None
    youngs_modulus_gpa: float = Field(ge=YOUNG.least, le=YOUNG.most)
    poissons_ratio: float = Field(ge=0, le=0.5)
    hardness_gpa: Hardness | None = None
    yield_strength_gpa: float | None = Field(default=None, gt=0, le=HARDNESS.most / library.YIELDS)
    plasticity: Literal["memoryless", "permanent"] | None = None
    density_kg_m3: float | None = Field(default=None, ge=DENSITY.least, le=DENSITY.most)
    thickness_mm: float | None = Field(default=None, gt=0)
    loss_factor: float | None = Field(default=None, gt=0, le=1)
    length_mm: float | None = Field(default=None, gt=0)
    width_mm: float | None = Field(default=None, gt=0)
    contact_mm: Point | None = None
    contact_path: Literal["fixed", "to-and-fro"] | None = None
    contact_end_mm: Point | None = None
    contact_loss_factor: float | None = Field(default=None, ge=0, le=1)

    @property
    def cap_gpa(self) -> float:
        """Maximum pressure [GPa] that the plate bears, infinite for a purely elastic plate."""
        if self.yield_strength_gpa is not None:
            return library.YIELDS * self.yield_strength_gpa
        return self.hardness_gpa if isinstance(self.hardness_gpa, float) else math.inf

    @property
    def edges_mm(self) -> tuple[float, float] | None:
        """Length and width [mm] of a rectangular plate; None for an infinite one."""
        both = self.length_mm, self.width_mm
        return None if both[0] is None or both[1] is None else (both[0], both[1])

    @property
    def contact_ends_mm(self) -> dict[str, tuple[float, float]]:
        """Contact point (x, y) by key, and the other end of its path if it moves [mm]."""
        if self.edges_mm is None:
            return {}
        default = CONTACT_AT[0] * self.edges_mm[0], CONTACT_AT[1] * self.edges_mm[1]
        ends = {"contact_mm": self.contact_mm or default, "contact_end_mm": self.contact_end_mm}
        return {key: point for key, point in ends.items() if point is not None}

    @model_validator(mode="after")
    def _yields(self) -> Self:
        """Refuse a hardness beside a yield strength, a hardness above E/5, and memory without."""
        if self.yield_strength_gpa is not None and self.hardness_gpa is not None:
            raise fault(
                f"not beside hardness_gpa, which is {library.YIELDS} times as much",
                at="plate.yield_strength_gpa",
            )
        if self.youngs_modulus_gpa / HARDEST <= self.cap_gpa < math.inf:
            key, got, part, share = "hardness_gpa", self.cap_gpa, "fifth", HARDEST
            if self.yield_strength_gpa is not None:
                key, got = "yield_strength_gpa", self.yield_strength_gpa
                part, share = "fifteenth", HARDEST * library.YIELDS
            raise fault(
                f"got {plain_number(got)}, allowed: below a {part} of youngs_modulus_gpa,"
                f" {rounded(self.youngs_modulus_gpa / share, 4)}; without a hardness the plate is"
                " purely elastic",
                at=f"plate.{key}",
            )
        if self.plasticity == "permanent" and math.isinf(self.cap_gpa):
            raise fault(
                "missing; plasticity: permanent needs it, an elastic plate keeps its surface",
                at="plate.hardness_gpa",
            )
        return self

    @model_validator(mode="after")
    def _all_edges(self) -> Self:
        """Refuse half a rectangle, and keys of a contact point without edges."""
        if self.loss_factor is not None and self.thickness_mm is None:
            raise fault(
                "only goes with thickness_mm: a half-space has no bending waves",
                at="plate.loss_factor",
            )
        if self.edges_mm is None:
            rule = "a plate with edges needs both, an infinite plate neither"
            _refuse_half(self, ("length_mm", "width_mm"), rule)
            for key in ("contact_mm", "contact_path", "contact_end_mm"):
                if getattr(self, key) is not None:
                    raise fault(
                        "only goes with length_mm and width_mm: a point on an infinite plate is"
                        " like any other",
                        at=f"plate.{key}",
                    )
            return self
        if self.thickness_mm is None:
            raise fault("missing; a plate with edges bends", at="plate.thickness_mm")
        if self.loss_factor is None:
            raise fault(
                "missing; a plate with edges has modes, which decay", at="plate.loss_factor"
            )
        for key, point in self.contact_ends_mm.items():
            for axis, place, edge in zip("xy", point, self.edges_mm, strict=True):
                if not 0 < place < edge:
                    raise fault(
                        f"got {quoted(list(point))}, allowed: a point within the edges, {axis}"
                        f" above 0 and below {plain_number(edge)}",
                        at=f"plate.{key}",
                    )
        end = self.contact_end_mm
        moves = self.contact_path == "to-and-fro"
        if moves and end is None:
            raise fault("missing; contact_path: to-and-fro needs it", at="plate.contact_end_mm")
        if end is not None and not moves:
            raise fault("only goes with contact_path: to-and-fro", at="plate.contact_end_mm")
        if end is not None and end == self.contact_ends_mm["contact_mm"]:
            raise fault(
                f"got {quoted(list(end))}, the point contact_mm, allowed: another point",
                at="plate.contact_end_mm",
            )
        return self
