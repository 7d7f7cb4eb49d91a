"""The kinds of surface of a scene, each with its keys."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal

from pydantic import Field, model_validator

from acoustics.numbers import rounded
from rolling.scene import named
from rolling.scene.balls import WAVE_NODES
from rolling.scene.faults import SurfaceFault, SurfaceKind
from rolling.scene.laws import Roughness, SelfAffineLaw
from rolling.scene.messages import fault, plain_number
from rolling.scene.track import MAX_NODES, MIN_NODES


class PlateSurface(SurfaceKind):
    """Surface of a plate of any kind.

    Attributes
    ----------
    spacing_um : float
        Node spacing [um], along and across
    width_um : float
        Width across the track [um], a whole number of nodes, at least 8
    """

    SECTION: ClassVar[str] = "surface"

    spacing_um: float = Field(gt=0)
    width_um: float | None = Field(default=None, gt=0)

    @model_validator(mode="after")
    def _whole_width(self) -> PlateSurface:
        if self.width_um is not None:
            refuse_width(self.width_um, self.spacing_um)
        return self

    @property
    def n_across(self) -> int | None:
        """Nodes across the track; None: a file has them."""
        return None if self.width_um is None else round(self.width_um / self.spacing_um)


def refuse_width(width_um: float, spacing_um: float) -> None:
    """Raise a fault for a width that is no whole number of nodes, too small or too large."""
    nodes = width_um / spacing_um
    words = ""
    if not nodes < MAX_NODES:
        words = f"less than {rounded(MAX_NODES)} nodes"
    elif round(nodes) < MIN_NODES or abs(nodes - round(nodes)) > 1e-6 * nodes:
        fitting = max(MIN_NODES, round(nodes)) * spacing_um
        words = f"a whole number of nodes of {spacing_um:g} um, at least {MIN_NODES};"
        words += f" nearest: {fitting:.10g}"
    if words:
        raise fault(f"got {plain_number(width_um)}, allowed: {words}", "surface", "width_um")


class MadeSurface(PlateSurface):
    """Surface of a given width that the program generates."""

    width_um: float = Field(gt=0)


Finish = Annotated[
    str,
    Field(
        json_schema_extra=lambda schema: schema.update(enum=[*named.data("finishes")["finishes"]])
    ),
]


class Gaussian(Roughness, MadeSurface):
    """Random periodic surface by its autocorrelation, with Gaussian or other heights.

    Attributes
    ----------
    kind : "gaussian"
        A random surface by its autocorrelation
    finish : str, optional
        Name of a finish, which gives Ra, correlation lengths and law; values beside it win
    """

    NAMED: ClassVar[str] = "surface"

    kind: Literal["gaussian"] = "gaussian"
    finish: Finish | None = None
    faults: list[SurfaceFault] | None = None


class SelfAffine(SelfAffineLaw, MadeSurface):
    """Random periodic surface of a self-affine spectrum.

    Attributes
    ----------
    kind : "self-affine"
        A random surface of a self-affine spectrum
    """

    kind: Literal["self-affine"] = "self-affine"
    faults: list[SurfaceFault] | None = None

    @model_validator(mode="after")
    def _holds_waves(self) -> SelfAffine:
        least = WAVE_NODES * self.spacing_um
        if self.shortest_um < least * (1 - 1e-9):
            words = f"at least {WAVE_NODES} spacings, {rounded(least, 6)}"
            raise self.wrong("shortest_um", words, self.shortest_um)
        if not self.shortest_um <= self.rolloff_um <= self.width_um:
            words = f"from shortest_um, {self.shortest_um:g}, to width_um, {self.width_um:g}"
            raise self.wrong("rolloff_um", words, self.rolloff_um)
        return self


class Smooth(MadeSurface):
    """Perfectly flat surface.

    Attributes
    ----------
    kind : "smooth"
        A perfectly flat surface
    """

    kind: Literal["smooth"] = "smooth"
    faults: list[SurfaceFault] | None = None


class HeightFile(PlateSurface):
    """Surface read from a file, which holds one period of it.

    Attributes
    ----------
    kind : "file"
        Heights from a file; the track is the file
    path : str
        File of heights, .npy, .npz, .csv or .txt, shape (along track, across), relative to the
        scene file
    height_unit : str
        Unit of the heights in the file
    level : str
        Tilt: auto takes the least-squares plane off where the step from the last row to the first
        stands out and the plane lowers it, plane always, none never
    width_um : float, optional
        Width across the track [um] of a profile of one line, whose heights are the same all
        across: a whole number of nodes, at least 8; absent: the file holds lines side by side
    """

    kind: Literal["file"] = "file"
    path: str = Field(min_length=1)
    height_unit: Literal["m", "mm", "um", "nm"] = "m"
    level: Literal["auto", "plane", "none"] = "auto"
    faults: list[SurfaceFault] | None = None


Surface = Annotated[Gaussian | Smooth | HeightFile | SelfAffine, Field(discriminator="kind")]
