"""A damaged result.h5 is refused, never crashes and never hangs."""

from __future__ import annotations

from pathlib import Path

import h5py
import numpy as np
import pytest
from old_results import save_old
from stored_results import refusal

from rolling import cli
from rolling.folders import run_record
from rolling.folders.files import FolderError
from rolling.simulation import _hdf5_probe, result_file


def test_no_changed_byte_is_accepted(path: Path, monkeypatch) -> None:
    """The digest refuses flips, runs of zeros, truncations, insertions and additions.

    The HDF5 library never sees such a file.
    """
    monkeypatch.setattr(result_file, "_probed", lambda path: "the probe was reached")
    monkeypatch.setattr(
        result_file, "_read", lambda path, source: pytest.fail("the damaged file was opened")
    )
    good, rng = path.read_bytes(), np.random.default_rng(0)
    for k in range(400):
        # the digest's own bytes, too
        at = int(rng.integers(len(good))) if k % 4 else len(good) - 1 - k // 4
        bad = bytearray(good)
        kind = k % 7
        if kind < 4:
            bad[at] ^= 1 << int(rng.integers(8))
        elif kind == 4:
            bad = bad[:at]
        elif kind == 5:
            bad[at:at] = bytes(1)
        else:
            bad += bytes(rng.integers(0, 256, 1 + k % 3, dtype=np.uint8))
        path.write_bytes(bad)
        assert "damaged" in refusal(path) and "the probe was reached" in refusal(path)


def test_damaged_bytes_are_refused_by_the_command_with_one_message(path: Path, capsys) -> None:
    """The true probe refuses a few damaged files, and the message names the remedy."""
    run_record.write(path.parent, run_record.new("run"))
    good = path.read_bytes()
    for at in (9, 700, len(good) // 2, len(good) - 40):
        bad = bytearray(good)
        bad[at] ^= 4
        path.write_bytes(bad)
        assert cli.main(["resume", str(path.parent)]) == 2
        message = capsys.readouterr().err
        assert (
            "result.h5: " in message and "Traceback" not in message and message.count("\n") == 1
        ), message
    path.write_bytes(good[: len(good) // 2])
    assert cli.main(["resume", str(path.parent)]) == 2
    assert "delete the file, and `rolling resume` solves it again" in capsys.readouterr().err
    path.unlink()
    path.mkdir()
    assert "no such file" in refusal(path)


def test_a_file_that_another_program_changed_is_refused(path: Path) -> None:
    with h5py.File(path, "r+") as file:
        file["release_energy"][7] *= 2
    assert "events: their energy is" in refusal(path)  # the field that shows it
    with h5py.File(path, "r+") as file:
        file["release_energy"][7] /= 2
    assert "not the ones that were written" in refusal(path)


@pytest.mark.slow
def test_damaged_old_files_never_crash_and_never_hang(whole: Path, tmp_path: Path) -> None:
    """A file without a digest may pass with a flipped value, but ends in no traceback."""
    path = tmp_path / "result.h5"
    save_old(path, result_file.load(whole / "result.h5"), True)
    good, rng = path.read_bytes(), np.random.default_rng(1)
    for k in range(12):
        bad = bytearray(good)
        if k % 4 == 3:
            bad = bad[: int(rng.integers(len(good)))]
        else:  # the structure lies in the first and the last kilobytes
            for at in (
                rng.integers(0, 4000, 8) if k % 2 else len(good) - 1 - rng.integers(0, 30000, 30)
            ):
                bad[int(at)] ^= 1 << int(rng.integers(8))
        path.write_bytes(bad)
        try:
            result_file.load(path)
        except FolderError as error:
            assert str(error).startswith(str(path))


@pytest.mark.parametrize(
    ("program", "message"),
    [
        ("import os; os.kill(os.getpid(), 11)", "crashes the HDF5 library"),
        ("while True: pass", "does not come to an end"),
        ("bytearray(1 << 36)", "MemoryError"),
    ],
)
def test_a_probe_that_dies_is_a_refusal(
    program: str, message: str, tmp_path: Path, monkeypatch
) -> None:
    (tmp_path / "probe.py").write_text(program)
    (tmp_path / "result.h5").write_bytes(b"\x89HDF\r\n\x1a\n" + bytes(500))
    monkeypatch.setattr(_hdf5_probe, "__file__", str(tmp_path / "probe.py"))
    monkeypatch.setattr(_hdf5_probe, "SECONDS", 0.5)
    assert message in refusal(tmp_path / "result.h5")
