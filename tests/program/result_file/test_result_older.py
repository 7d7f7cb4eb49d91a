"""A result.h5 of an earlier version is read, and its run is gone on with."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from old_results import save_old
from stored_results import same

from rolling import cli
from rolling.commands import work
from rolling.simulation import result_file
from rolling.simulation.result import Result


@pytest.mark.parametrize("deflection", [False, True])
def test_old_files_are_read_and_gone_on_with(
    deflection: bool, whole: Path, partial: Result, tmp_path: Path
) -> None:
    for given in (result_file.load(whole / "result.h5"), partial):
        save_old(tmp_path / "result.h5", given, deflection)
        result = result_file.load(tmp_path / "result.h5")
        assert result.identity is None
        expected = given.series | (
            {} if deflection else {"max_deflection": np.full(given.steps + 1, np.nan)}
        )
        assert same(result, replace(given, identity=None, trial=None, series=expected))
    # The missing piece, then the file of today.
    shutil.copy(whole / "resolved.yaml", tmp_path)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(work, "write_pictures", lambda *_: [])
        shutil.copy(whole / "scene.yaml", tmp_path)
        assert cli.main(["resume", str(tmp_path), "--workers", "1"]) == 0
    result, once = result_file.load(tmp_path / "result.h5"), result_file.load(whole / "result.h5")
    assert result.complete and result.identity == once.identity
    for name in ("release_energy", "approach", "iterations"):
        assert np.array_equal(result.series[name], once.series[name])
    assert np.isnan(result.series["max_deflection"]).any() != deflection


def test_an_old_file_of_another_length_is_refused(
    whole: Path, partial: Result, tmp_path: Path, capsys
) -> None:
    save_old(tmp_path / "result.h5", partial, True)
    text = (whole / "resolved.yaml").read_text()
    (tmp_path / "resolved.yaml").write_text(text.replace("duration_s: 0.006", "duration_s: 0.004"))
    assert cli.main(["resume", str(tmp_path)]) == 2
    assert f"has {partial.steps} steps, the scene asks for" in capsys.readouterr().err
