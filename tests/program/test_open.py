"""The link to the newest folder, `--open`, and the title of the page."""

from __future__ import annotations

import webbrowser
from pathlib import Path

import pytest
from scene_text import TINY

from rolling import cli
from rolling.folders import new_folder

SCENE = TINY + 'title: "Ball & plate <b>: 5 N"\n'


def test_the_link_points_to_the_newest_folder(tmp_path: Path) -> None:
    for name in ("2026-01-01T00-00-00", "2026-01-02T00-00-00"):
        (tmp_path / name).mkdir()
        new_folder.link_latest(tmp_path / name)
        assert (tmp_path / "latest").resolve() == tmp_path / name
    assert sorted(path.name for path in tmp_path.iterdir())[-1] == "latest"
    assert len(list(tmp_path.iterdir())) == 3


def test_a_file_with_the_name_of_the_link_stays(tmp_path: Path) -> None:
    (tmp_path / "latest").write_text("mine")
    (tmp_path / "2026-01-01T00-00-00").mkdir()
    new_folder.link_latest(tmp_path / "2026-01-01T00-00-00")
    assert (tmp_path / "latest").read_text() == "mine"


@pytest.mark.parametrize("found", [True, False])
def test_a_run_opens_its_page(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], found: bool
) -> None:
    opened: list[str] = []
    monkeypatch.setattr(webbrowser, "open", lambda page: bool(opened.append(page)) or found)
    monkeypatch.chdir(tmp_path)
    scene = tmp_path / "scene.yaml"
    scene.write_text(SCENE)
    assert cli.main(["run", str(scene), "--open", "--workers", "1"]) == 0
    (link,) = tmp_path.glob("outputs/*/latest")
    page = link.resolve() / "report.html"
    assert opened == [page.as_uri()]
    assert ("no browser was found" in capsys.readouterr().err) == (not found)
    html = page.read_text(encoding="utf-8")
    assert "<h1>Ball &amp; plate &lt;b&gt;: 5 N</h1>" in html and "plate <b>" not in html
