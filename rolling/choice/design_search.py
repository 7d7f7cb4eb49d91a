"""Search for the least change of a surface with which a scene is quieter by some decibels.

The linear response of the contact says which waves to lower. The changed surface is marched beside
the surface as it is, with the same random phases, and the fall that the response aims at is
corrected until the marches give the one that was asked for.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from acoustics.arrays import Array
from acoustics.pairs import FEWEST_PAIRS, FIRST_PAIRS, MOST_PAIRS
from rolling.choice.advice import write_advice
from rolling.choice.audition import audition_of
from rolling.choice.candidate import Candidate
from rolling.choice.choice_numbers import Contender, OmittedPair
from rolling.choice.choosing import OpenChoice, default_folder, open_choice
from rolling.choice.design import LEAST_SHOWN_DB, Design, Round, nearest
from rolling.choice.heard_specimen import HeardQuantity
from rolling.choice.least_change import fall_of, least_change
from rolling.choice.sensitivity import quantity_of, refuse_sweep
from rolling.choice.wave_bands import PlateBands, PlateWaves
from rolling.scene.identity import digest
from rolling.scene.messages import SceneError, is_number, quoted
from rolling.surface.lowered_waves import nominal
from rolling.terminal import progress, whole_files

KEY = "surface.lowered_db"
MOST_DB = 60.0  # of a fall that is asked for, and of a band that is lowered
ROUNDS = 5  # changed surfaces that are marched at most
NEAR = 0.02  # relative distance from the fall that was asked for, which ends the search
NEAR_DB = 0.03  # and the absolute one
FLOOR_DB = 0.05  # distance from the largest possible fall that is left
TARGET = "target-psd.csv"
SCENE = "design.yaml"


def design_scene(
    scene: Any,
    quieter_db: float,
    folder: Path | None = None,
    pairs: int = FIRST_PAIRS,
    workers: int = 0,
) -> Design:
    """Find which waves of the plate must be lower for a quieter scene, with the least change.

    Parameters
    ----------
    scene : scene. A scene without a sweep, of a ball that rolls on a rough plate.
    quieter_db : float, dB. Wanted fall of the level, above 0 and up to 60.
    folder : Path. Folder of the specimens. Default: outputs/design-DIGITS.
    pairs : int. Number of specimens, from 2 to 30, on which changed surfaces are marched, and of
        others, whose response to waves is taken.
    workers : int. Number of processes; 0: one per core.

    Raises
    ------
    SceneError : the scene sweeps, cannot run, makes no sound, or has no waves that could be lower,
        or so large a fall is not possible.
    FolderError : the folder holds something else.
    ContactError : a contact has no solution.
    OSError, KeyboardInterrupt : finished pieces are kept.
    """
    refuse_sweep(scene)
    if not (is_number(quieter_db) and 0 < quieter_db <= MOST_DB):
        raise SceneError(
            [f"quieter: got {quoted(quieter_db)}, allowed: above 0 and up to {MOST_DB:g} dB"]
        )
    if type(pairs) is not int or not FEWEST_PAIRS <= pairs <= MOST_PAIRS // 2:
        raise SceneError(
            [
                f"pairs: got {quoted(pairs)}, allowed: a whole number from {FEWEST_PAIRS} to"
                f" {MOST_PAIRS // 2}"
            ]
        )
    audition = audition_of(scene)
    waves = audition.plate_waves(scene)  # which refuses a scene without any
    base = audition.unchanged(scene)
    quantity = quantity_of(audition.quantities([base]), None)
    target = folder or default_folder("design", [base.scene])
    with open_choice([base], target, workers) as work:
        count = min(2 * pairs, work.specimens.count)
        search = DesignSearch(
            work=work,
            base=base,
            waves=waves,
            quantity=quantity,
            quieter_db=float(quieter_db),
            count=count,
        )
        return search.run()


@dataclass
class DesignSearch:
    """Marches changed surfaces until the level falls by what was asked for.

    work, base, waves, quantity : The open folder, the candidate, its waves and what is heard.
    quieter_db : float, dB. The fall that was asked for.
    count : int. Number of specimens, of which half are marched with changed surfaces.
    """

    work: OpenChoice
    base: Candidate
    waves: PlateWaves
    quantity: HeardQuantity
    quieter_db: float
    count: int
    omitted: dict[int, OmittedPair] = field(default_factory=dict)

    @property
    def marched_count(self) -> int:
        """Number of specimens on which changed surfaces are marched."""
        return math.ceil(self.count / 2)

    def run(self) -> Design:
        """Return the design."""
        ((base,), _) = self.work.hear([self.base], self.count)
        name = self.base.scene.name
        if not np.all(np.isfinite(base.levels_in(self.quantity.name))):
            raise SceneError([f"{name}: makes no sound within hearing, so none could be quieter"])
        unmarched = self._unmarched(base)
        bands = self.waves.bands(unmarched.specimens, self.work.correlation(unmarched, unmarched))
        if not bands.is_known:
            more = "more specimens (--pairs) or a longer track would tell"
            if bands.correlation is not None:
                more = "a longer or wider scan would tell"
            raise SceneError(
                [
                    f"{name}: the level does not surely fall with all waves of the plate (by"
                    f" {bands.response.sum():.2f} dB per decibel), so none is named; {more}"
                ]
            )
        self._refuse_too_much(bands)
        rounds, doubt = self._confirmed(bands)
        answer = nearest(rounds, self.quieter_db)
        return Design(
            name=name,
            quantity=self.quantity,
            quieter_db=self.quieter_db,
            bands=bands,
            rounds=rounds,
            doubt=doubt,
            noun=self.work.specimens.noun,
            folder=self.work.folder,
            scene=self.base.scene,
            changed=self._changed(bands.wavelength_m, answer.lowered_db).scene,
            omitted=[*self.omitted.values()],
        )

    def _unmarched(self, base: Contender) -> Contender:
        """Return the specimens of a contender on which no changed surface is marched.

        A response fits its own specimens better than others. So the fall is marched on specimens
        that have no part in it, unless there is a single one.
        """
        places = [
            place
            for place, specimen in enumerate(base.specimens)
            if specimen.number >= self.marched_count
        ]
        if not places:
            return base
        return replace(
            base,
            heard=[base.heard[place] for place in places],
            specimens=[base.specimens[place] for place in places],
        )

    def _refuse_too_much(self, bands: PlateBands) -> None:
        """Refuse a fall that not even a plate without waves has."""
        if not self.waves.has_other_sources:
            return
        without = np.full(len(bands.wavelength_m), MOST_DB)
        fall_db = self._march(bands.wavelength_m, without, math.inf).fall_db
        if self.quieter_db <= fall_db - FLOOR_DB:
            return
        can = f"can be met: up to {max(0.0, fall_db - FLOOR_DB):.1f} dB"
        raise SceneError(
            [
                f"quieter: got {self.quieter_db:g} dB, but with no waves on the plate at all the"
                f" scene is {fall_db:.1f} dB quieter, because the surface of the sphere or single"
                f" faults stay; {can}"
            ]
        )

    def _confirmed(self, bands: PlateBands) -> tuple[list[Round], str]:
        """Return the changed surfaces that were marched, and what is not known of the response.

        The finest response that marches confirm counts. On few specimens or short tracks single
        bands are known by chance, and to lower them does nothing.
        """
        *finer, coarsest = bands.resolutions
        for resolution in finer:
            rounds = self._rounds(resolution.response, bands.wavelength_m, ends_early=True)
            best = nearest(rounds, self.quieter_db)
            if not (self._is_short(best) or _fails(rounds[-1])):
                return rounds, resolution.doubt
            progress.line("the marches do not confirm this response, so a coarser one follows")
        rounds = self._rounds(coarsest.response, bands.wavelength_m, ends_early=False)
        best = nearest(rounds, self.quieter_db)
        if best.fall_db < self.quieter_db / 2:
            raise SceneError(
                [
                    f"quieter: got {self.quieter_db:g} dB, but with waves lowered by"
                    f" {best.lowered_db.max():.1f} dB the level changes by {-best.fall_db:+.1f} dB"
                    f" over {best.fall.pairs} {self.work.specimens.noun}, so these do not tell"
                    " which waves sound; allowed: more specimens (--pairs) or a longer track"
                ]
            )
        if self._is_short(best):
            raise SceneError(
                [
                    f"quieter: got {self.quieter_db:g} dB, but with bands lowered by up to"
                    f" {MOST_DB:g} dB the scene is {best.fall_db:.1f} dB quieter; allowed: up to"
                    " that, or more specimens (--pairs), which make more bands known"
                ]
            )
        return rounds, coarsest.doubt

    def _is_short(self, best: Round) -> bool:
        """Whether a surface falls short of what was asked for, and no band can be lower."""
        return best.fall_db < self.quieter_db and best.lowered_db.max() >= MOST_DB

    def _rounds(self, response: Array, wavelength_m: Array, ends_early: bool) -> list[Round]:
        """Return the changed surfaces that were marched, in their order.

        Parameters
        ----------
        response : (bands,) array, dB/dB
            The response that says which bands to lower.
        wavelength_m : (bands,) array, m
            Middles of the bands.
        ends_early : bool
            Whether a surface that fails ends the search.
        """
        rounds: list[Round] = []
        aimed_db = self.quieter_db
        for _ in range(ROUNDS):
            lowered = np.minimum(least_change(response, aimed_db), MOST_DB)
            lowered = np.where(lowered >= LEAST_SHOWN_DB, np.round(lowered, 2), 0.0)
            if not lowered.any():
                lowered[np.argmax(response)] = LEAST_SHOWN_DB
            rounds.append(self._march(wavelength_m, lowered, fall_of(response, lowered)))
            off_db = abs(rounds[-1].fall_db - self.quieter_db)
            if off_db <= max(NEAR * self.quieter_db, NEAR_DB):
                break
            if ends_early and _fails(rounds[-1]):
                return rounds
            following_db = _next_aim(rounds, self.quieter_db)
            if following_db is None:
                break
            aimed_db = following_db
        return rounds

    def _march(self, wavelength_m: Array, lowered_db: Array, aimed_db: float) -> Round:
        """March the surface as it is and with lower waves, and return the fall of the level."""
        changed = self._changed(wavelength_m, lowered_db)
        (base, quiet), omitted = self.work.hear([self.base, changed], self.marched_count)
        for pair in omitted:
            self.omitted.setdefault(pair.number, pair)
        fall = self.work.audition.difference(
            self.quantity.name,
            base.heard,
            quiet.heard,
            omitted=len(omitted),
            correlation=self.work.correlation(base, quiet),
        )
        made = Round(aimed_db=aimed_db, lowered_db=lowered_db, fall=fall)
        progress.line(
            f"waves lowered by up to {lowered_db.max():.1f} dB: {made.fall_db:.2f}"
            f" {self.quantity.decibels} quieter over {_pairs(base)}"
        )
        return made

    def _changed(self, wavelength_m: Array, lowered_db: Array) -> Candidate:
        """Return the candidate whose waves are lowered, beside what the scene lowers itself."""
        own = self.base.scene.surface.lowered_db or {}
        whole = {nominal(1e6 * middle): 0.0 for middle in wavelength_m}
        whole |= {nominal(wavelength): db for wavelength, db in own.items()}
        for middle, db in zip(wavelength_m, lowered_db, strict=True):
            whole[nominal(1e6 * middle)] += float(db)
        values = {float(name): round(db, 2) for name, db in whole.items() if db > 0}
        label = f"lower waves {digest(list(values.items()))[:8]}"
        return self.work.audition.with_value(self.base, KEY, values, label)


def _fails(marched: Round) -> bool:
    """Whether the level falls by less than half of what the linear response aims at."""
    return marched.fall_db < marched.aimed_db / 2


def _pairs(contender: Contender) -> str:
    """Write the number of specimens of a contender."""
    return f"{len(contender.heard)} specimens"


def _next_aim(rounds: list[Round], wanted_db: float) -> float | None:
    """Return the fall that the linear response aims at next; None where it has no better one.

    The fall that is marched grows with the one that is aimed at: between two of them it follows a
    line, and beyond it is proportional.
    """
    known = sorted(
        (marched.fall_db, marched.aimed_db) for marched in rounds if math.isfinite(marched.fall_db)
    )
    silent = [marched.aimed_db for marched in rounds if not math.isfinite(marched.fall_db)]
    below = [pair for pair in known if pair[0] < wanted_db]
    above = [pair for pair in known if pair[0] >= wanted_db]
    if below and above:
        (low, aim_low), (high, aim_high) = below[-1], above[0]
        return aim_low + (aim_high - aim_low) * (wanted_db - low) / (high - low)
    if above:
        return above[0][1] * wanted_db / above[0][0]
    if not below:
        return min(silent) / 2
    fall_db, aimed_db = below[-1]
    if fall_db <= 0:
        aimed_db = max(aimed for _, aimed in below)
        return None if aimed_db > MOST_DB else 2 * aimed_db
    following = aimed_db * min(4.0, wanted_db / fall_db)
    if silent:
        following = min(following, (aimed_db + min(silent)) / 2)
    return following


# ---- files


def write_design(result: Design) -> list[Path]:
    """Write table, target, scene, picture and page of a design, and return the files."""
    from rolling.choice.advice_page import design_page
    from rolling.choice.advice_pictures import design_picture
    from rolling.results.runs_table import csv_bytes
    from rolling.run.folder import with_relative_paths
    from rolling.scene import file

    target = result.folder / TARGET
    head = "".join(f"# {line}\n" for line in target_notes(result))
    whole_files.write_bytes(target, head.encode() + csv_bytes(result.target()))
    scene = result.folder / SCENE
    changed = with_relative_paths(result.folder, result.changed)
    whole_files.write_bytes(scene, file.dump(changed).encode())
    table, *others = write_advice(result, "design", design_picture, design_page)
    return [table, target, scene, *others]


def target_notes(result: Design) -> list[str]:
    """Return what a workshop has to know of a target, line by line."""
    return [
        "Target of profiles along the rolling direction, in third octaves of wavelength.",
        result.sentences[0],
        *result.conditions.lines,
        "psd: one-sided power spectral density, mean over the band [um2 um]; amplitudes are rms.",
        "Waves without decibels may stay as they are.",
    ]
