"""Marches of contacts that runs share, in files of the run folder that outlast the command.

Scenes of equal contact are marched once, over all runs of a sweep. The march of a contact is
stored in `contacts/IDENTITY.npz` of the run folder, and its pieces are removed then. Its scene
stands beside it, and `rolling run` takes it. A run may take equal marches from the folder of
another one, which is judged as the file of a stranger.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from acoustics.arrays import Array, short_repr
from rolling.archive.definition import TEXT, Variable, by_name
from rolling.archive.npz_file import npz_bytes, read_npz
from rolling.archive.sealed_file import seal, sealed_content
from rolling.check import forecast
from rolling.check.findings import Findings
from rolling.check.marched import check_contacts, refuse_contacts
from rolling.kinds.kind import Kind
from rolling.kinds.needed_marches import March, MarchStore
from rolling.kinds.run_folder import RunFolder
from rolling.marches.effort import PieceEffort
from rolling.marches.march_variables import EFFORT
from rolling.marches.piece import contact_identity
from rolling.marches.result import Result
from rolling.run import folder as folders
from rolling.run.taken import OTHER_CONTACT, TakenMarches
from rolling.scene import file as scene_file
from rolling.scene.scene import Scene
from rolling.scene.sweep import run_name
from rolling.terminal import progress
from rolling.terminal.streams import folded
from rolling.terminal.whole_files import FolderError, make_below, write_bytes

CONTACTS = "contacts"  # folder of the marches, in the run folder
_MAX_BESIDE = 10_000  # bytes of the file of a march beside its approach
_IDENTITY = Variable("identity", "", "1", TEXT, "contact identity")
_VARIABLES = by_name(  # of the file of a march
    Variable("approach_m", "place", "m", "f8", "approach at each position"),
    Variable("numbers", "number", "Pa, m2", "f8", "maximum pressure, and mean contact area"),
    EFFORT,
    _IDENTITY,
)


@dataclass(frozen=True)
class ContactMarch:
    """March of a contact along its closed track.

    approach_m : (steps,) array, m. Approach at each position.
    max_pressure_pa : float, Pa. Maximum pressure along the track.
    contact_area_m2 : float, m2. Mean contact area.
    effort : PieceEffort, s. Processor times; zeros for a march that was taken from another run.
    """

    __repr__ = short_repr

    approach_m: Array
    max_pressure_pa: float
    contact_area_m2: float
    effort: PieceEffort


Marches = Mapping[str, ContactMarch]  # by contact identity


class ContactStore(MarchStore):
    """Marches of contacts that runs share: in memory, or in files that outlast the command.

    folder : Path or None. Run folder, whose marches are taken and kept; None for memory alone.
    homes : sequence of Path. Folders of other runs, whose sound marches are taken.
    """

    def __init__(self, folder: Path | None = None, homes: Sequence[Path] = ()) -> None:
        self._folder = folder
        self._homes = homes
        self.is_lasting = folder is not None

    def find(self, march: March, identity: str) -> ContactMarch | None:
        """Return the march of a contact from a file, if there is one that is sound."""
        known = None
        if self._folder is not None:
            known = _sound_march(self._folder, march.scene, identity)
        if known is not None:
            return known
        for home in self._homes:
            known = _sound_march(home, march.scene, identity)
            if known is not None:
                known = replace(known, effort=PieceEffort(0.0, 0.0, 0.0))  # of another run
                self._write(march.scene, identity, known)
                return known
        return None

    def keep(self, march: March, identity: str, result: Result) -> ContactMarch:
        """Return the march of a contact from its complete result, and write its file."""
        whole = march_of(result)
        self._write(march.scene, identity, whole)
        return whole

    def _write(self, scene: Scene, identity: str, march: ContactMarch) -> None:
        """Write the file of a march with its scene beside it, where there is a folder."""
        if self._folder is not None:
            _write_scene(self._folder, scene, identity)
            _write_march(self._folder, identity, march)


class MarchesInFiles(Kind):
    """Kind whose scenes are judged by their marches, which runs share and keep in files."""

    def refuse(
        self, scene: Any, workers: int, folder: Path | None, unsolved: Sequence[Any] | None = None
    ) -> None:
        """Refuse a scene whose contacts cannot be marched here."""
        if unsolved is None:
            unsolved = [run for _, run in scene.runs()]
        contacts = [march.scene for run in unsolved for march in self.marches(run)]
        refuse_contacts(contacts, workers, folder)

    def check(self, scene: Any, solve: bool = True) -> Findings:
        """Judge the contacts of all runs of a scene; none of them is solved."""
        return check_contacts(
            {
                run_name(values) or scene.name: [march.scene for march in self.marches(run)]
                for values, run in scene.runs()
            }
        )

    def conclusion(self, scene: Any, findings: Findings) -> str:
        """State in a sentence how long a scene takes."""
        if findings.refusal is not None:
            return f"It does not run: {findings.refusal.text}."
        return f"It runs in {forecast.takes(findings.seconds)}."

    def lines_in_short(self, scene: Any, findings: Findings) -> list[str]:
        """Return the conclusion of a check, and its warnings."""
        warnings = [folded(f"warning: {line}") for line in findings.warnings]
        return [folded(self.conclusion(scene, findings), ""), *warnings]

    def march_store(
        self,
        folder: Path | None = None,
        done: Sequence[RunFolder] = (),
        sources: Sequence[RunFolder] = (),
    ) -> ContactStore:
        """Return the files of marches of the folder, and of the folders of runs elsewhere."""
        return ContactStore(folder, list(dict.fromkeys(run.home for run in sources)))

    def take_marches(
        self, start_from: Path, elsewhere: Sequence[RunFolder], own: Sequence[RunFolder]
    ) -> list[RunFolder]:
        """Return runs elsewhere with marches that own runs lack, and say which ones these are."""
        taken = TakenMarches(elsewhere[0].home)
        contacts: dict[str, March] = {}
        for run in own:
            if not run.is_done:
                for march in self.marches(run.scene):
                    contacts.setdefault(contact_identity(march.scene), march)
        has_some = [take_march(taken, march) for march in contacts.values()]
        for line in taken.lines():
            progress.line(line)
        return list(elsewhere) if any(has_some) else []


def march_of(result: Result) -> ContactMarch:
    """Return the march of a contact from its complete result."""
    return ContactMarch(
        approach_m=result.series["approach"][: result.solved_steps],
        max_pressure_pa=float(result.series["max_pressure"].max()),
        contact_area_m2=float(result.series["contact_area"].mean()),
        effort=result.effort.of_march(),
    )


# ---- files


def march_path(folder: Path, identity: str) -> Path:
    """Return the file of a march in a run folder."""
    return folder / CONTACTS / f"{identity[:32]}.npz"


def _write_march(folder: Path, identity: str, march: ContactMarch) -> None:
    """Write the file of a march, with its identity and a digest at its end."""
    arrays = {
        "approach_m": march.approach_m,
        "numbers": np.array([march.max_pressure_pa, march.contact_area_m2]),
        EFFORT.name: np.array(march.effort),
        _IDENTITY.name: np.array(identity),
    }
    content = npz_bytes(_VARIABLES, arrays)
    write_bytes(march_path(folder, identity), content + seal(content))


def _write_scene(folder: Path, scene: Scene, identity: str) -> None:
    """Write the scene of a march beside its file."""
    home = folder / CONTACTS
    make_below(folder, home)
    path = march_path(folder, identity).with_suffix(".yaml")
    text = scene_file.dump(folders.with_relative_paths(home, scene))
    write_bytes(path, text.encode())


def _sound_march(folder: Path, scene: Scene, identity: str) -> ContactMarch | None:
    """Read the march of a contact in a run folder; None for a missing or damaged file."""
    with suppress(FolderError):
        return read_march(folder, scene, identity)
    return None


def take_march(taken: TakenMarches, march: March) -> bool:
    """Note whether the folder of other runs has a sound march of a contact, and return it."""
    scene = march.scene
    identity = contact_identity(scene)
    name = f"{scene.name} at {scene.load:g} N"
    if not march_path(taken.folder, identity).exists():
        taken.leave(name, OTHER_CONTACT)
        return False
    try:
        read_march(taken.folder, scene, identity)
    except FolderError as error:
        taken.leave(name, str(error))
        return False
    taken.take(name)
    return True


def read_march(folder: Path, scene: Scene, identity: str) -> ContactMarch:
    """Read the march of a contact from a run folder that a stranger may have made.

    Raises
    ------
    FolderError : the file is missing or damaged, or holds another march.
    """
    path = march_path(folder, identity)
    steps = scene.track.solved_steps
    content = sealed_content(path, 8 * steps + _MAX_BESIDE)
    lengths = {"place": steps, "number": 2, "part": len(PieceEffort._fields)}
    try:
        arrays = read_npz(content, _VARIABLES, lengths)
        if str(arrays.pop(_IDENTITY.name)) != identity:
            raise ValueError("the march of another contact")
        if not all(np.all(np.isfinite(values)) for values in arrays.values()):
            raise ValueError("values that are no finite numbers")
    except Exception as error:  # of any kind on hostile files
        text = " ".join(str(error).split()) or type(error).__name__
        raise FolderError(f"{path}: no march of this contact ({text})") from error
    pressure, area = arrays["numbers"].tolist()
    return ContactMarch(
        approach_m=arrays["approach_m"],
        max_pressure_pa=pressure,
        contact_area_m2=area,
        effort=PieceEffort(*arrays[EFFORT.name].tolist()),
    )
