"""The parts that all pictures of README and docs share: scenes, kept runs, and what is shown."""

from __future__ import annotations

import re
import tempfile
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from build_cache import ROOT

PICTURES = ROOT / "scenarios" / "pictures"
OUT = Path("outputs") / "pictures"
BLOCK = "^```{language}\n(.*?)^```"


class Shown(NamedTuple):
    """What a picture shows.

    numbers : dict. The numbers, as they are printed.
    pages : dict of lists of str. Texts that state them, by the page that must contain them.
    caption : str. What to see on the picture; empty if its page says it in its own words.
    """

    numbers: dict[str, Any]
    pages: dict[str, list[str]]
    caption: str = ""


class PictureScene(NamedTuple):
    """A scene that a picture shows.

    name : str. Name of a scene that comes with the program, or a page whose first block of YAML is
        the scene.
    settings : sequence of str. Settings on top of it, as after `--set`.
    """

    name: str
    settings: Sequence[str] = ()

    def read(self) -> Any:
        """Return the scene with its settings."""
        from rolling import read_scene

        if not self.name.endswith(".md"):
            return read_scene(ROOT / "scenarios" / f"{self.name}.yaml", self.settings)
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "scene.yaml"
            file.write_text(first_block(ROOT / self.name, "yaml"), encoding="utf-8")
            return read_scene(file, self.settings)


class Picture(NamedTuple):
    """A picture, or a table of a page, and how it is made.

    name : str. Name of its command.
    stem : str. Name of its files in scenarios/pictures, without an ending.
    make : function of the file of the picture. Writes it, and returns what it shows.
    scenes : dict. The scenes that are run, by their labels on the picture.
    blocks : str. A page whose blocks are computed in place of scenes. Default: none.
    ending : str. Ending of its file; empty if there is no picture beside the JSON.
    has_dark : bool. Whether a second file shows it on a dark page.
    is_quick : bool. Whether it is made without a march, in a second.
    """

    name: str
    stem: str
    make: Callable[[Path], Shown]
    scenes: Mapping[str, PictureScene]
    blocks: str = ""
    ending: str = ".png"
    has_dark: bool = False
    is_quick: bool = False

    @property
    def is_drawn(self) -> bool:
        """Whether there is a picture beside the JSON."""
        return bool(self.ending)

    @property
    def path(self) -> Path:
        """The file of the picture."""
        return PICTURES / f"{self.stem}{self.ending}"


def scenes_of(settings_by_name: Mapping[str, Sequence[str]]) -> dict[str, PictureScene]:
    """Return scenes that come with the program, labelled by their names."""
    return {name: PictureScene(name, settings) for name, settings in settings_by_name.items()}


def dark_twin(path: Path) -> Path:
    """Return the file that shows a picture on a dark page."""
    return path.with_name(f"{path.stem}-dark{path.suffix}")


def first_block(page: Path, language: str) -> str:
    """Return the first block of a language on a page."""
    pattern = BLOCK.format(language=language)
    found = re.search(pattern, page.read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE)
    assert found is not None
    return found[1]


# ---- runs


def run_folder(name: str) -> Path:
    """Return the folder of a run of these sources of the program."""
    from rolling.terminal import program

    return OUT / program.identity().sources[: program.SHOWN] / name


def kept_run(scene: Any) -> Any:
    """Return the run of a scene, simulated unless these sources have run it before."""
    from rolling import open_run, simulate
    from rolling.scene.identity import scene_identity

    folder = run_folder(scene_identity(scene)[:16])
    if not folder.exists():
        simulate(scene, progress=False).save(folder, report=False)
    return open_run(folder)
