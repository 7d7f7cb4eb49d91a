"""Definitions of archives: the arrays and facts that a file may hold, as frozen data.

An archive is a tree of groups, and a group has arrays with named dimensions and attributes. Equal
names of dimensions within a group have equal lengths. The definition says how an array is written,
what is read of a file, and what a person finds in xarray.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

from numpy.typing import NDArray

Arrays = dict[str, NDArray[Any]]
Attribute = str | int | float

ROOT = ""  # name of the group at the top
TEXT = "text"  # type of texts of any length
LETTERS = "S1"  # type of single letters, which have one dimension more in a file of HDF5
LETTER = "letter"  # name of this dimension


@dataclass(frozen=True)
class Variable:
    """Definition of an array of an archive.

    name : str. Name in its group.
    dimensions : str. Names of its dimensions, separated by spaces.
    unit : str. SI unit, "1" for a pure number, "position" or "step" for a place along the track.
    dtype : str. Type in the file without byte order, such as f8. Whole numbers are stored as such.
        LETTERS are of files of HDF5, and TEXT is of archives and of studies, which xarray writes.
    long_name : str. Meaning, for readers of netCDF.
    is_auxiliary : bool. Whether it is a coordinate, though not named as its dimension.
    scale_factor : str. Name of the attribute of the group that is the unit of the stored whole
        numbers; empty for an array that is stored in its unit.
    may_be_single : bool. Whether one value may stand for all, without dimensions.
    """

    name: str
    dimensions: str
    unit: str
    dtype: str
    long_name: str
    is_auxiliary: bool = False
    scale_factor: str = ""
    may_be_single: bool = False

    @property
    def axes(self) -> tuple[str, ...]:
        """Names of its dimensions."""
        return tuple(self.dimensions.split())

    @property
    def is_coordinate(self) -> bool:
        """Whether it goes beside each array of its dimensions."""
        return self.is_auxiliary or self.name in self.axes

    def refuse_shape(self, shape: tuple[int, ...], lengths: dict[str, int], path: str) -> None:
        """Refuse a shape that does not fit the lengths of dimensions; note those met first.

        Raises
        ------
        ValueError : the shape has other dimensions or another length; the message names the path.
        """
        axes = () if self.may_be_single and shape == () else self.axes
        if len(shape) != len(axes):
            raise ValueError(f"{path}: got {len(shape)} dimensions, allowed: {len(axes)}")
        for axis, length in zip(axes, shape, strict=True):
            allowed = lengths.setdefault(axis, length)
            if length != allowed:
                raise ValueError(f"{path}: got {length} along {axis}, allowed: {allowed}")


def by_name(*variables: Variable) -> dict[str, Variable]:
    """Return definitions of arrays by their names."""
    return {variable.name: variable for variable in variables}


Series = Mapping[Variable, NDArray[Any]]  # arrays that runs of a sweep have in common


@dataclass(frozen=True)
class GroupDefinition:
    """Definition of a group: its arrays, and the types of its attributes by name.

    variables : tuple of Variable. Arrays that the group may have.
    attributes : mapping. str, int or float by the name of an attribute that it may have.
    """

    variables: tuple[Variable, ...]
    attributes: Mapping[str, type[Attribute]] = field(default_factory=dict)

    @cached_property
    def by_name(self) -> dict[str, Variable]:
        """Definitions of its arrays by name."""
        return by_name(*self.variables)


@dataclass(frozen=True)
class ArchiveDefinition:
    """Definition of an archive.

    name : str. Words of messages for such an archive, such as "a result".
    format : int. Number of the format, an attribute of the root.
    kind : str. Attribute `kind` of the root, by which a file is known; empty for none.
    groups : mapping. Definitions of its groups by name, with that of the ROOT.
    """

    name: str
    format: int
    kind: str
    groups: Mapping[str, GroupDefinition]


@dataclass(frozen=True)
class ArchiveGroup:
    """Content of a group.

    arrays : dict. Arrays by name.
    attributes : mapping. Texts and numbers by name, each of its defined type.
    """

    arrays: Arrays
    attributes: Mapping[str, Any] = field(default_factory=dict)


Archive = Mapping[str, ArchiveGroup]  # by name of the group; the root is there


def in_group(group: str, arrays: Mapping[str, NDArray[Any]]) -> Arrays:
    """Return the arrays of a group by their names in an archive, which has no groups."""
    return {f"{group}/{name}": values for name, values in arrays.items()}


def of_group(group: str, arrays: Mapping[str, NDArray[Any]]) -> Arrays:
    """Return those arrays of an archive that are in a group, by their names there."""
    begin = f"{group}/"
    return {
        name.removeprefix(begin): values
        for name, values in arrays.items()
        if name.startswith(begin)
    }
