"""The kinds of surface of a scene, each with its keys."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal

from pydantic import Field, model_validator

from acoustics.numbers import rounded
from rolling.scene.balls import Roughness
from rolling.scene.faults import SurfaceFault
from rolling.scene.messages import fault, plain_number
from rolling.scene.sections import Section
from rolling.scene.track import MAX_NODES, MIN_NODES


class MadeSurface(Section):
    """Surface of a given width that the program generates."""

    SECTION: ClassVar[str] = "surface"
    IN_FILES: ClassVar[str] = "kind"

    kind: str
    spacing_um: float = Field(gt=0)
    width_um: float = Field(gt=0)

    @model_validator(mode="after")
    def _whole_width(self) -> MadeSurface:
        _refuse_width(self.width_um, self.spacing_um)
        return self

    @property
    def n_across(self) -> int:
        """Nodes across the track."""
        return round(self.width_um / self.spacing_um)

    @property
    def law(self) -> Roughness | None:
        """Law of the random heights, None without random heights."""
        return None


def _refuse_width(width_um: float, spacing_um: float) -> None:
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


class Gaussian(Roughness, MadeSurface):
    """Random periodic surface with Gaussian heights.

    Attributes
    ----------
    kind : "gaussian"
        A random surface with Gaussian heights
    spacing_um : float
        Node spacing [um], along and across
    width_um : float
        Width across the track [um], a whole number of nodes, at least 8
    autocorrelation : str
        Law in the distance r and the correlation length L: gaussian exp(-(r/L)^2), gaussian_10pct
        exp(-2.3 (r/L)^2), exponential exp(-r/L), exponential_10pct exp(-2.3 r/L)
    roughness_ra_um : float
        Arithmetic mean roughness Ra [um]
    correlation_length_um : float
        Correlation length [um], along the track
    correlation_length_across_um : float, optional
        Correlation length across the track [um]; absent: the same as along
    seed : int
        Seed of the random heights
    faults : list of SurfaceFault, optional
        Single faults of the surface
    """

    kind: Literal["gaussian"] = "gaussian"
    faults: list[SurfaceFault] | None = None


class Smooth(MadeSurface):
    """Perfectly flat surface.

    Attributes
    ----------
    kind : "smooth"
        A perfectly flat surface
    spacing_um : float
        Node spacing [um], along and across
    width_um : float
        Width across the track [um], a whole number of nodes, at least 8
    faults : list of SurfaceFault, optional
        Single faults of the surface
    """

    kind: Literal["smooth"] = "smooth"
    faults: list[SurfaceFault] | None = None


class HeightFile(Section):
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
    spacing_um : float
        Node spacing [um], along and across
    level : str
        Tilt: auto takes the least-squares plane off where the step from the last row to the first
        stands out and the plane lowers it, plane always, none never
    width_um : float, optional
        Width across the track [um] of a profile of one line, whose heights are the same all
        across: a whole number of nodes, at least 8; absent: the file holds lines side by side
    faults : list of SurfaceFault, optional
        Single faults of the surface, added to the heights of the file
    """

    SECTION: ClassVar[str] = "surface"
    IN_FILES: ClassVar[str] = "kind"

    kind: Literal["file"] = "file"
    path: str = Field(min_length=1)
    height_unit: Literal["m", "mm", "um", "nm"] = "m"
    spacing_um: float = Field(gt=0)
    level: Literal["auto", "plane", "none"] = "auto"
    width_um: float | None = Field(default=None, gt=0)
    faults: list[SurfaceFault] | None = None

    @model_validator(mode="after")
    def _whole_width(self) -> HeightFile:
        if self.width_um is not None:
            _refuse_width(self.width_um, self.spacing_um)
        return self

    @property
    def n_across(self) -> int | None:
        """Nodes across the track that a profile is laid over; None: the file has them."""
        return None if self.width_um is None else round(self.width_um / self.spacing_um)


Surface = Annotated[Gaussian | Smooth | HeightFile, Field(discriminator="kind")]
