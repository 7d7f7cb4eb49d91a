"""The kinds of surface of a scene, each with its keys."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal

from pydantic import ConfigDict, Field, model_validator

from rolling.scene.messages import fault, plain_number
from rolling.scene.sections import Section, required_in_files
from rolling.scene.track import MAX_NODES, MIN_NODES


class MadeSurface(Section):
    """Surface of a given width that the program generates."""

    SECTION: ClassVar[str] = "surface"

    kind: str
    spacing_um: float = Field(gt=0, description="Node spacing [um], along and across")
    width_um: float = Field(
        gt=0, description="Width across the track [um], a whole number of nodes, at least 8"
    )

    @model_validator(mode="after")
    def _whole_width(self) -> MadeSurface:
        _refuse_width(self.width_um, self.spacing_um)
        return self

    @property
    def n_across(self) -> int:
        """Nodes across the track."""
        return round(self.width_um / self.spacing_um)


def _refuse_width(width_um: float, spacing_um: float) -> None:
    """Raise a fault for a width that is no whole number of nodes, too small or too large."""
    nodes = width_um / spacing_um
    if not nodes < MAX_NODES:
        raise fault(
            f"got {plain_number(width_um)}, allowed: less than {MAX_NODES:g} nodes",
            "surface",
            "width_um",
        )
    if round(nodes) < MIN_NODES or abs(nodes - round(nodes)) > 1e-6 * nodes:
        fitting = max(MIN_NODES, round(nodes)) * spacing_um
        raise fault(
            f"got {plain_number(width_um)}, allowed: a whole number of nodes of {spacing_um:g} um,"
            f" at least {MIN_NODES}; nearest: {fitting:.10g}",
            "surface",
            "width_um",
        )


class Gaussian(MadeSurface):
    """Random periodic surface with Gaussian heights."""

    model_config = ConfigDict(json_schema_extra=required_in_files("kind"))

    kind: Literal["gaussian"] = Field(
        default="gaussian", description="A random surface with Gaussian heights"
    )
    autocorrelation: Literal["gaussian", "gaussian_10pct", "exponential", "exponential_10pct"] = (
        Field(
            default="gaussian",
            description="Law in the distance r and the correlation length L: gaussian"
            " exp(-(r/L)^2), gaussian_10pct exp(-2.3 (r/L)^2), exponential exp(-r/L),"
            " exponential_10pct exp(-2.3 r/L)",
        )
    )
    roughness_ra_um: float = Field(gt=0, le=1000, description="Arithmetic mean roughness Ra [um]")
    correlation_length_um: float = Field(
        gt=0, description="Correlation length [um], along the track"
    )
    correlation_length_across_um: float | None = Field(
        default=None,
        gt=0,
        description="Correlation length across the track [um]; absent: the same as along",
    )
    seed: int = Field(ge=0, description="Seed of the random heights")


class Smooth(MadeSurface):
    """Perfectly flat surface."""

    model_config = ConfigDict(json_schema_extra=required_in_files("kind"))

    kind: Literal["smooth"] = Field(default="smooth", description="A perfectly flat surface")


class HeightFile(Section):
    """Surface read from a file, which holds one period of it."""

    model_config = ConfigDict(json_schema_extra=required_in_files("kind"))
    SECTION: ClassVar[str] = "surface"

    kind: Literal["file"] = Field(
        default="file", description="Heights from a file; the track is the file"
    )
    path: str = Field(
        min_length=1,
        description="File of heights, .npy, .npz, .csv or .txt, shape (along track, across),"
        " relative to the scene file",
    )
    height_unit: Literal["m", "mm", "um", "nm"] = Field(
        default="m", description="Unit of the heights in the file"
    )
    spacing_um: float = Field(gt=0, description="Node spacing [um], along and across")
    level: Literal["auto", "plane", "none"] = Field(
        default="auto",
        description="Tilt: auto takes the least-squares plane off where the step from the last"
        " row to the first stands out and the plane lowers it, plane always, none"
        " never",
    )
    width_um: float | None = Field(
        default=None,
        gt=0,
        description="Width across the track [um] of a profile of one line, whose heights are the"
        " same all across: a whole number of nodes, at least 8; absent: the file holds lines side"
        " by side",
    )

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
