"""Files and links that a stranger leaves in a folder reach nothing outside it and run nothing."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from rolling.terminal.files import write_bytes

SCENE = """\
name: short
sphere: {radius_mm: 5}
plate: {youngs_modulus_gpa: 210, poissons_ratio: 0.3, hardness_gpa: 2.1}
surface:
  {kind: gaussian, roughness_ra_um: 0.1, correlation_length_um: 10, spacing_um: 2, width_um: 128,
   seed: 1}
rolling: {load_n: 0.5, speed_m_s: 0.1, duration_s: 0.01}
numerics: {tolerance: 1.0e-4}
"""


def test_a_link_at_a_temporary_name_does_not_lead_to_its_target(tmp_path: Path) -> None:
    victim = tmp_path / "victim"
    victim.write_text("precious")
    (tmp_path / ".report.html.partial").symlink_to(victim)
    write_bytes(tmp_path / "report.html", b"page")
    assert victim.read_text() == "precious"
    assert (tmp_path / "report.html").read_bytes() == b"page"


def test_even_a_guessed_temporary_name_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("secrets.token_hex", lambda count: "0" * 2 * count)
    victim = tmp_path / "victim"
    victim.write_text("precious")
    (tmp_path / f".report.html.{'0' * 16}.partial").symlink_to(victim)
    with pytest.raises(FileExistsError):
        write_bytes(tmp_path / "report.html", b"page")
    assert victim.read_text() == "precious"
    assert not (tmp_path / "report.html").exists()


def test_a_written_file_has_the_permissions_of_the_umask(tmp_path: Path) -> None:
    before = os.umask(0o027)
    try:
        write_bytes(tmp_path / "a", b"")
    finally:
        os.umask(before)
    assert (tmp_path / "a").stat().st_mode & 0o777 == 0o640


def test_workers_import_nothing_from_the_working_directory(tmp_path: Path) -> None:
    (tmp_path / "scene.yaml").write_text(SCENE)
    for name in ("pickle", "numpy", "struct"):
        (tmp_path / f"{name}.py").write_text("open('hijacked', 'a').close(); raise SystemExit(1)")
    program = (
        tmp_path / "bin" / "program.py"
    )  # as the console script, which is no part of the folder
    program.parent.mkdir()
    program.write_text("from rolling.cli import main\nraise SystemExit(main())\n")
    command = [sys.executable, program, "run", "scene.yaml", "--out", "out", "--workers", "2"]
    done = subprocess.run(
        [*command, "--no-report"], cwd=tmp_path, capture_output=True, text=True, timeout=300
    )
    assert not (tmp_path / "hijacked").exists(), done.stderr
    assert done.returncode == 0, done.stderr
