"""`rolling extend` writes a long record of the same bands, and refuses what it cannot extend."""

from __future__ import annotations

import json

import numpy as np
import pytest

from acoustics import level, wav
from acoustics.bands import third_octave_mean_square
from acoustics.spectrum import line_spectrum
from rolling import cli
from rolling.folders import own_files, run_record


def test_a_long_record_has_the_bands_of_the_short_one(runs, capsys) -> None:
    folder = runs.one()
    assert cli.main(["extend", str(folder), "--seconds", "5"]) == 0
    said = capsys.readouterr()
    assert said.out.splitlines() == [str(folder / "extended.wav")]
    assert "kurtosis" in said.err
    about = json.loads((folder / "extended.json").read_text())
    samples, rate, comment = wav.read(folder / "extended.wav")
    extended = samples * about["pascal_per_full_scale"]
    record, _, _ = wav.read(folder / "signal.wav")
    assert len(extended) == 5 * rate and "extended: stationary Gaussian noise" in comment
    assert np.abs(samples).max() <= wav.PEAK + 1e-6
    assert level.laeq_db(extended, rate) == pytest.approx(about["laeq_db"], abs=0.05)
    before, after = (
        third_octave_mean_square(*line_spectrum(each, rate)) for each in (record, extended)
    )
    heard = before > 1e-9 * before.max()  # the file is rounded to 24 bits
    assert heard.sum() > 15
    assert np.abs(10 * np.log10(after[heard] / before[heard])).max() < 0.1
    assert about["kurtosis"] == pytest.approx(3.0, abs=0.2)
    assert about["record_kurtosis"] != about["kurtosis"]
    for name in ("extended.wav", "extended.json"):
        assert name in own_files.FILES["run"]
        (folder / name).unlink()
    record = run_record.read(folder)
    assert record is not None and own_files.foreign(folder, record) == []


@pytest.mark.parametrize(
    ("name", "seconds", "words"),
    [
        ("one", "0.5", "the record itself is 0.9 s long"),
        ("one", "601", "allowed is up to 600"),
        ("smooth", "5", "silent"),
        ("braking", "5", "its speed changes"),
    ],
)
def test_what_cannot_be_extended_is_refused(name, seconds, words, runs, capsys) -> None:
    folder = getattr(runs, name)()
    assert cli.main(["extend", str(folder), "--seconds", seconds]) == 2
    assert words in capsys.readouterr().err
    assert not (folder / "extended.wav").exists()
