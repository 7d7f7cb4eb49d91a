"""Fixtures of the tests of result.h5: a finished run, its file, and an interrupted result."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
from scene_text import BODIES, MADE

from rolling import cli, commands
from rolling.commands import work
from rolling.simulation import simulate
from rolling.simulation.result import Result

SCENE = f"""\
name: small
{BODIES}{MADE}\
rolling: {{load_n: 0.3, speed_m_s: [[0, 0.1], [0.004, 0.2]], duration_s: 0.006}}
recovery: {{events: true}}
"""


@pytest.fixture(scope="session")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a finished run folder of three pieces, with events and a changing speed."""
    folder = tmp_path_factory.mktemp("runs")
    (folder / "s.yaml").write_text(SCENE)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(work, "write_pictures", lambda *_: [])
        assert (
            cli.main(
                ["run", str(folder / "s.yaml"), "--out", str(folder / "out"), "--workers", "1"]
            )
            == 0
        )
    return folder / "out"


@pytest.fixture
def path(whole: Path, tmp_path: Path) -> Path:
    shutil.copy(whole / "resolved.yaml", tmp_path)
    return Path(shutil.copy(whole / "result.h5", tmp_path))


def part(whole: Path) -> Result:
    """Return the first and third piece, as an interrupted run on two workers leaves them."""
    one = commands.read_runs(whole)[0]
    result = Result.empty(one.scene.track, one.scene.start)
    for first, last in simulate.pieces(result.solved_steps)[::2]:
        result.add(simulate.simulate_piece(one.scene, first, last))
    result.identity = simulate.identity_of(one.scene)
    return result


@pytest.fixture(scope="session")
def partial(whole: Path) -> Result:
    return part(whole)
