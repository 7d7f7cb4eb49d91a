"""Channels of a scene: what accelerometers or force transducers would record beside the sound."""

from typing import Any, ClassVar, Literal, Self

from pydantic import Field, ValidationInfo, field_validator, model_validator

from rolling.scene.messages import mistake, plain_number, quoted
from rolling.scene.models import Section

MAX_CHANNELS = 16
MOTIONS = ("acceleration", "velocity", "displacement")
FORCES = ("force", "blocked_force")


class SoundChannel(Section):
    """Channel of a run: motion of plate or ball, or a contact force.

    Attributes
    ----------
    of : str
        What moves or presses: plate, ball or contact
    quantity : str
        acceleration, velocity or displacement of plate or ball, force or blocked_force of the
        contact. The blocked force is that on a rigid plate.
    x_mm : float, optional
        Place on the plate [mm] along x: from the corner of contact_mm on a plate with edges, from
        the contact along the track on an infinite one. Default: the contact point.
    y_mm : float, optional
        Place on the plate [mm] along y, as x_mm
    name : str, optional
        Name of the channel. Default: quantity and place in words.

    Examples
    --------
    >>> import rolling
    >>> rolling.SoundChannel(of="plate", quantity="velocity", x_mm=30, y_mm=0).label
    'plate velocity at (30, 0) mm'
    """

    SECTION: ClassVar[str] = "channels"

    of: Literal["plate", "ball", "contact"]
    quantity: Literal["acceleration", "velocity", "displacement", "force", "blocked_force"]
    x_mm: float | None = None
    y_mm: float | None = None
    name: str | None = Field(default=None, min_length=1, max_length=60)

    @field_validator("quantity")
    @classmethod
    def _check_quantity(cls, quantity: str, info: ValidationInfo) -> str:
        """Refuse a force of plate or ball, and a motion of the contact."""
        of = info.data.get("of")
        if of is None:
            return quantity
        allowed = FORCES if of == "contact" else MOTIONS
        if quantity not in allowed:
            raise mistake(f"got {quoted(quantity)}, allowed with of: {of}: {', '.join(allowed)}")
        return quantity

    @field_validator("x_mm")
    @classmethod
    def _check_x(cls, place: float | None, info: ValidationInfo) -> float | None:
        """Refuse a place of ball or contact."""
        if place is not None and info.data.get("of") not in (None, "plate"):
            raise mistake(f"got {plain_number(place)}, which only goes with of: plate")
        return place

    @model_validator(mode="after")
    def _check_place(self) -> Self:
        """Refuse one coordinate without the other, and one of ball or contact."""
        if self.y_mm is not None and self.of != "plate":
            raise mistake("y_mm: only goes with of: plate")
        if (self.x_mm is None) != (self.y_mm is None):
            missing = "x_mm" if self.x_mm is None else "y_mm"
            raise mistake(f"{missing}: missing; a place has both x_mm and y_mm")
        return self

    @property
    def place_mm(self) -> tuple[float, float] | None:
        """Place (x, y) on the plate [mm]; None for the contact point."""
        if self.x_mm is None or self.y_mm is None:
            return None
        return self.x_mm, self.y_mm

    @property
    def label(self) -> str:
        """Name of the channel, by default its quantity and place in words."""
        if self.name is not None:
            return self.name
        if self.quantity == "force":
            return "contact force"
        if self.quantity == "blocked_force":
            return "blocked force"
        if self.of == "ball":
            return f"ball {self.quantity}"
        if self.place_mm is None:
            return f"plate {self.quantity} at the contact"
        x, y = self.place_mm
        return f"plate {self.quantity} at ({plain_number(x)}, {plain_number(y)}) mm"


def refuse_equal_names(channels: list[SoundChannel]) -> None:
    """Refuse two channels of one name."""
    first: dict[str, int] = {}
    for number, channel in enumerate(channels):
        if channel.label in first:
            raise mistake(
                f"got {quoted(channel.label)} twice, as channels {first[channel.label] + 1} and"
                f" {number + 1}, allowed: different channels, each with a name of its own",
                at=("sound", "channels", number),
            )
        first[channel.label] = number


def refuse_channels(channels: list[SoundChannel], sections: Any) -> None:
    """Refuse channels without dynamics, places outside the plate, and motion that is not known."""
    if not channels:
        return
    plate = sections.get("plate")
    rolling = sections.get("rolling")
    if "dynamics" in sections and sections["dynamics"] is None:
        raise mistake(
            "only goes with dynamics, which moves ball and plate; `dynamics: {}` takes its"
            " defaults",
            at="sound.channels",
            needs=["dynamics"],
        )
    for number, channel in enumerate(channels):
        at = ("sound", "channels", number)
        falls = rolling is not None and rolling.falls
        if channel.of == "ball" and channel.quantity != "acceleration" and falls:
            raise mistake(
                f"got {quoted(channel.quantity)}, allowed with rolling.drop_mm: acceleration; a"
                " ball that falls has no rest",
                at=(*at, "quantity"),
            )
        if channel.of != "plate" or plate is None:
            continue
        if plate.thickness_mm is None:
            raise mistake(
                'got "plate", which needs plate.thickness_mm: a half-space has no bending waves,'
                " and its motion away from the contact is not computed; allowed without it: ball,"
                " contact",
                at=(*at, "of"),
                needs=["plate.thickness_mm"],
            )
        if plate.edges_mm is None or channel.place_mm is None:
            continue
        for key, place, edge in zip(
            ("x_mm", "y_mm"), channel.place_mm, plate.edges_mm, strict=True
        ):
            if not 0 <= place <= edge:
                raise mistake(
                    f"got {plain_number(place)}, outside the plate, allowed: from 0 to"
                    f" {plain_number(edge)}",
                    at=(*at, key),
                )
