"""The judged claims of a study as data: verdicts, extent of the readings, standing and scores.

`Table.to_dict` is the only place where they become plain data for JSON.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any

from rolling.lee2025.checks import Finding
from rolling.lee2025.statements import Claim

READING, VARIATION, SWEEP = "reading", "variation", "sweep"


@dataclass(frozen=True)
class Judgement:
    """The finding of one reading on one claim.

    Parameters
    ----------
    reading : str. Name of the reading.
    scale : int or None. 10 or 20, the factor of lg in a level; None where no level is judged.
    finding : Finding. The verdict with its numbers.
    """

    reading: str
    scale: int | None
    finding: Finding

    def to_dict(self) -> dict[str, Any]:
        """Return plain data for JSON."""
        plain = asdict(self.finding)
        plain["numbers"] = plain["numbers"] or {}
        for places in filter(None, (plain, plain["finer"])):
            name = "places" if places is plain["finer"] else "grid_places"
            places[name] = [list(place) for place in places[name]]
        return {"reading": self.reading, "scale": self.scale, **plain}


@dataclass(frozen=True)
class JudgedClaim:
    """A claim with the judgements of all readings, by reading and then by scale.

    Parameters
    ----------
    outlook : bool. True for a statement that the article only expects; it earns no score.
    """

    claim: Claim
    judgements: tuple[Judgement, ...] = ()
    outlook: bool = False

    def of(self, reading: str) -> list[Judgement]:
        """Return the judgements of one reading."""
        return [judgement for judgement in self.judgements if judgement.reading == reading]

    def to_dict(self) -> dict[str, Any]:
        """Return plain data for JSON."""
        claim = self.claim
        return {
            "key": claim.key,
            "where": claim.where,
            "statement": claim.statement,
            "tolerance": claim.tolerance,
            "caution": claim.caution,
            "outlook": self.outlook,
            "swept": claim.varied,
            "findings": [judgement.to_dict() for judgement in self.judgements],
        }


@dataclass(frozen=True)
class Extent:
    """The solved part of a reading, compared with the article's own cases.

    Parameters
    ----------
    kind : str. READING, VARIATION or SWEEP.
    assumptions : str. The choices that the reading takes for granted, in words.
    departs : tuple of str. Its differences from the article's statements; empty for a reading.
    cases : int. Number of solved cases.
    roughnesses_um, loads_n, durations_s : tuple of float, um, N, s. Values that occur, rising.
    surfaces : int. Number of different surfaces per roughness.
    swept : str or None. The field of Case that it varies besides roughness and load.
    lacks : tuple of str. Roughnesses, loads and single cases of the article that are missing.
    """

    kind: str
    assumptions: str = ""
    departs: tuple[str, ...] = ()
    cases: int = 0
    roughnesses_um: tuple[float, ...] = ()
    loads_n: tuple[float, ...] = ()
    surfaces: int = 0
    durations_s: tuple[float, ...] = ()
    swept: str | None = None
    lacks: tuple[str, ...] = ()

    def to_dict(self) -> dict[str, Any]:
        """Return plain data for JSON, where the assumptions have the key `what`."""
        plain = {
            name: list(value) if isinstance(value, tuple) else value
            for name, value in asdict(self).items()
        }
        return {"kind": plain.pop("kind"), "what": plain.pop("assumptions"), **plain}


@dataclass(frozen=True)
class Standing:
    """Keys of all claims, sorted by their verdicts in all readings, with either scale of levels.

    Parameters
    ----------
    every, part, none : list of str. Reproduced, partly reproduced or not reproduced in each
        reading.
    undecided : list of str. Undecided in at least one reading; the other readings allow any of the
        lists above.
    differs : list of str. The verdict depends on the reading or on the scale of levels.
    not_run : list of str. No reading can tell.
    """

    every: list[str] = field(default_factory=list)
    part: list[str] = field(default_factory=list)
    none: list[str] = field(default_factory=list)
    undecided: list[str] = field(default_factory=list)
    differs: list[str] = field(default_factory=list)
    not_run: list[str] = field(default_factory=list)

    @property
    def judged(self) -> int:
        """The number of claims with a verdict in at least one reading."""
        return sum(
            len(keys) for keys in (self.every, self.part, self.none, self.undecided, self.differs)
        )

    def to_dict(self) -> dict[str, list[str]]:
        """Return plain data for JSON."""
        return {
            "not run" if name == "not_run" else name: keys for name, keys in asdict(self).items()
        }


@dataclass(frozen=True)
class Score:
    """The number of claims that a reading reproduces with one scale; "partly" counts half.

    Parameters
    ----------
    least, most : float. The score with each undecided verdict at its worse and at its better end.
    counts : mapping from str to int. Number of claims by verdict.
    judged : int. Number of claims with a verdict.
    """

    reading: str
    scale: int
    least: float
    most: float
    counts: Mapping[str, int]
    judged: int = 0

    @property
    def range(self) -> str:
        """The score in words, such as "10 to 10.5"."""
        return " to ".join(dict.fromkeys(f"{end:g}" for end in (self.least, self.most)))


@dataclass(frozen=True)
class Table:
    """All claims, judged under all readings and variations.

    Parameters
    ----------
    readings : mapping from str to Extent. All readings, variations and sweeps by name.
    twins : tuple of str. Names of the scenes without hardness, which serve for comparison only.
    claims : tuple of JudgedClaim. First the claims of the study, then the outlook.
    standing : Standing or None. The verdicts of the readings taken together, without variations.
    scores : tuple of Score. Readings, then variations, each from the highest down.
    """

    readings: Mapping[str, Extent] = field(default_factory=dict)
    twins: tuple[str, ...] = ()
    claims: tuple[JudgedClaim, ...] = ()
    standing: Standing | None = None
    scores: tuple[Score, ...] = ()

    def of_kind(self, kind: str) -> list[str]:
        """Return the names of all readings of a kind."""
        return [name for name, extent in self.readings.items() if extent.kind == kind]

    def kind(self, name: str, default: str = READING) -> str:
        """Return the kind of a reading, or the default kind for an unknown name."""
        return self.readings[name].kind if name in self.readings else default

    def to_dict(self) -> dict[str, Any]:
        """Return plain data for JSON: all numbers are finite or None."""
        return {
            "readings": {name: extent.to_dict() for name, extent in self.readings.items()},
            "twins": list(self.twins),
            "claims": [claim.to_dict() for claim in self.claims],
            "standing": self.standing.to_dict() if self.standing else None,
            "scores": [asdict(score) for score in self.scores],
        }
