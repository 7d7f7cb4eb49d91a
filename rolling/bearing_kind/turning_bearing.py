"""A ball bearing that turns: its rough contacts are marched, and its ring moves over them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from acoustics.ring_velocity import VELOCITY_BANDS_HZ
from rolling.bearing.ring_record import NOTHING_UM_S
from rolling.bearing_kind import bearing_lines, bearing_sentences, bearing_simulation, stored_run
from rolling.bearing_kind.bearing_check import check_bearing
from rolling.bearing_kind.bearing_in_short import conclusion, lines_in_short
from rolling.bearing_kind.bearing_run import BearingRun
from rolling.bearing_kind.contact_marches import march_of_contact
from rolling.bearing_kind.contact_plan import contact_plan
from rolling.bearing_kind.first_motion import pilot_of
from rolling.bearing_kind.former_bearing import former_bearing
from rolling.check.findings import Findings
from rolling.kinds.figure_kind import FigureKind
from rolling.kinds.heard_sound import HeardSound
from rolling.kinds.kind import Pilot
from rolling.kinds.machine import Machine
from rolling.kinds.needed_marches import March
from rolling.kinds.page_parts import PageParts
from rolling.kinds.run_folder import LISTEN, RunFolder
from rolling.marches.piece import contact_identity
from rolling.numbers.bearing_numbers import BearingNumbers
from rolling.numbers.conditions import Condition, Method
from rolling.numbers.quantity import Quantity
from rolling.numbers.run_file import BEARING_KIND, StoredBearing
from rolling.results import shared_lines
from rolling.run.march_files import ContactMarch, Marches, MarchesInFiles
from rolling.scene.bearing_scene import BearingScene
from rolling.terminal import defaults

if TYPE_CHECKING:
    from rolling.archive.definition import Series
    from rolling.bearing_kind.bearing_audition import BearingAudition
    from rolling.numbers.sheet import Sheet
    from rolling.recordings.compared_run import ComparedRun
    from rolling.recordings.recorded import MeasuredQuantity


class TurningBearing(MarchesInFiles):
    """A ball bearing that turns under a constant load."""

    name = BEARING_KIND
    scene_type = BearingScene
    description = (
        "A ball bearing: its geometry, surfaces, loads and speed, and the plate on which it is"
        " heard."
    )
    stored_type = StoredBearing
    former_format = 1
    noise = "bearing noise"
    gallery_note = (
        "Bearings: velocities of the ring that vibrates, in the three bands of ISO 15242-1 as far"
        " as the ring is rigid. Charts: the spectrum of the velocity with its lines."
    )
    card_figure = "spectrum"
    leading = tuple(f"below_bending_radial_{band}_um_s" for band in VELOCITY_BANDS_HZ)

    # ---- scenes

    def refuse(
        self,
        scene: BearingScene,
        workers: int,
        folder: Path | None,
        unsolved: Sequence[BearingScene] | None = None,
    ) -> None:
        """Refuse a scene that cannot be run here."""
        if unsolved is None:
            unsolved = [run for _, run in scene.runs()]
        bearing_simulation.refuse(scene, workers, folder, unsolved)

    def check(self, scene: BearingScene, solve: bool = True) -> Findings:
        """Judge all runs of a scene before they are run; no contact is solved."""
        return check_bearing(scene)

    def conclusion(self, scene: BearingScene, findings: Findings) -> str:
        """State in a sentence how long a scene takes, and with which verdict at best."""
        return conclusion(findings)

    def lines_in_short(self, scene: BearingScene, findings: Findings) -> list[str]:
        """Return the conclusion of a check, the numbers that a designer asks for, and doubts."""
        return lines_in_short(findings)

    # ---- marches

    def marches(self, scene: BearingScene, film: bool = False) -> list[March]:
        """Return the faults and the rough contacts at their middle load, then all other loads."""
        faults, rough, rest = contact_plan(scene).stages
        marches = [march_of_contact(contact) for contact in faults]
        return marches + [march_of_contact(contact, is_first=False) for contact in rough + rest]

    def pilot(self, scene: BearingScene) -> Pilot | None:
        """Return a short motion over rough contacts that are linear, which need no march."""
        return pilot_of(scene)

    def first_answer(self, numbers: BearingNumbers) -> str:
        """Say the radial velocity of each band with its ±, and the classes by the limits."""
        return bearing_sentences.first_answer(numbers)

    # ---- runs

    def make_run(self, place: RunFolder, label: str, marched: Sequence[ContactMarch]) -> BearingRun:
        """Move the ring over the tracks of all marches, and make its numbers."""
        return bearing_simulation.make_run(place, label, self._by_identity(place.scene, marched))

    def _by_identity(self, scene: BearingScene, marched: Sequence[ContactMarch]) -> Marches:
        """Return the marches of a scene by their contact identities; a pilot has the first ones."""
        return {
            contact_identity(march.scene): known
            for march, known in zip(self.marches(scene), marched, strict=False)
        }

    def write_run(self, run: BearingRun) -> None:
        """Write the files of a run into its folder."""
        stored_run.write_run(run)

    def read_run(self, place: RunFolder, label: str) -> BearingRun:
        """Read a run from its folder."""
        return bearing_simulation.read_run(place, label)

    def former_stored(self, content: bytes) -> StoredBearing:
        """Return the numbers of a run of version 0.8."""
        return former_bearing(content)

    def sounds(self, run: BearingRun) -> list[HeardSound]:
        """Return the acceleration of the ring, and the sound of a housing plate."""
        return stored_run.sounds(run)

    def write_long(
        self,
        run: BearingRun,
        seconds: float,
        speed: Any,
        seed: int,
        reverberation_s: float | None,
    ) -> Path:
        """Let the ring move for longer, and write long.wav."""
        if reverberation_s is not None:
            words = "long.wav of a bearing is the acceleration of its ring, which no room carries"
            raise ValueError(f"--reverberation: {words}")
        if speed is not None or seed:
            raise ValueError("--speed, --seed: a bearing turns on at the speed of its scene")
        return stored_run.write_long(run, seconds)

    def series(self, run: BearingRun) -> Series:
        """Return the motion of the ring, the loads of the balls, and the tracks."""
        return stored_run.series_of(run)

    def compared(self, run: BearingRun, quantity: MeasuredQuantity) -> ComparedRun:
        """Return the motion of the ring of a run, or the sound of its housing plate."""
        from rolling.bearing_kind.compared_records import records_of_bearing

        return records_of_bearing(run, quantity)

    # ---- how runs are shown

    def answer_lines(self, done: Sequence[RunFolder]) -> list[str]:
        """Return the sentences of a run, or the bands of several."""
        return bearing_lines.answer_lines(done)

    def doubt_lines(self, done: Sequence[RunFolder]) -> list[str]:
        """Return the doubts about runs, the worst first."""
        return shared_lines.doubt_lines(done)

    def further_lines(self, done: Sequence[RunFolder]) -> list[str]:
        """Return the lines of the spectra of runs."""
        return bearing_lines.further_lines(done)

    def listen_lines(self, done: Sequence[RunFolder]) -> list[str]:
        """Name the sound of the ring, and that of the housing where there is one."""
        sounds = [("listen", LISTEN, ""), ("listen to the housing", stored_run.HOUSING, "")]
        return shared_lines.listen_lines(done, sounds)

    def quantities(self, numbers: BearingNumbers) -> dict[str, Quantity]:
        """Return the radial velocities of the ring in the bands, as far as it does not bend.

        Their meanings say where the bands end. A ring that hardly moves is at rest, which has no ±.
        """
        holds_hz = numbers.ring.holds_hz
        words = bearing_sentences.band_words(numbers.ring)
        quantities = {}
        for band, quantity in numbers.below_bending.radial.by_band.items():
            if band not in words:
                reason = f"the ring bends from {holds_hz:,.0f} Hz on"
                quantity = replace(quantity, value=None, uncertainty=None, reason=reason)
            else:
                quantity = replace(quantity, meaning=f"Velocity of the ring from {words[band]}")
                if quantity.value is not None and quantity.value < NOTHING_UM_S:
                    quantity = replace(quantity, value=0.0, uncertainty=None)
            quantities[bearing_sentences.QUANTITY_NAMES[band]] = quantity
        return quantities

    def card_sentence(self, run: BearingRun) -> str:
        """Return the first sentence of the answer."""
        return run.numbers.sentences[0].replace(" um/s", " µm/s")

    def machine(self, scenes: Sequence[BearingScene], numbers: Sequence[Any] = ()) -> Machine:
        """Draw the bearing with its load zone, its balls and its faults."""
        from rolling.bearing_kind.bearing_machine import bearing_machine

        return bearing_machine(scenes)

    def figures(self) -> Mapping[str, FigureKind]:
        """Return spectrum, envelope, load distribution and ball forces of a run."""
        from rolling.bearing_kind.bearing_figures import FIGURES

        return FIGURES

    def subject(self, runs: Sequence[BearingRun]) -> str:
        """Say which bearing turns, how fast and under which loads, and what is varied."""
        from rolling.bearing_kind.bearing_sentences import condition
        from rolling.figures.picture import varied

        words = [condition(runs[0].scene)]
        if len(runs) > 1:
            named = runs[0].scene.bearing.named
            words = [f"bearing {named}" if named else runs[0].scene.name, *varied(runs)]
        text = ", ".join(words)
        return f"{text[0].upper()}{text[1:]}"

    def page_parts(self, runs: Sequence[BearingRun]) -> PageParts:
        """Return the parts of the page of bearings; of very many it has numbers alone."""
        if len(runs) > defaults.MAX_RUNS_ON_PAGE:
            return PageParts(has_plain_players=False)
        from rolling.bearing_kind.bearing_page import bearing_parts

        return bearing_parts(runs)

    # ---- sheets

    def conditions(self, scene: BearingScene) -> list[Condition]:
        """Return the conditions of a bearing, with how its surfaces were prepared."""
        from rolling.bearing_kind.bearing_conditions import conditions

        return conditions(scene)

    def method(self, scene: BearingScene) -> Method:
        """Return how the numbers of a bearing are computed."""
        from rolling.bearing_kind.bearing_conditions import method

        return method(scene)

    def sheets(self, run: BearingRun) -> list[Sheet]:
        """Return the vibration sheet, and the declaration of a housing plate."""
        from rolling.bearing_kind.bearing_sheets import housing_sheet, vibration_sheet

        sheets = [vibration_sheet(run)]
        of_housing = housing_sheet(run)
        if of_housing is not None:
            sheets.append(of_housing)
        return sheets

    # ---- choices

    def audition(self) -> BearingAudition:
        """Return how bearings are compared."""
        from rolling.bearing_kind.bearing_audition import BearingAudition

        return BearingAudition()


KIND = TurningBearing()
