"""Files of measured series: what is written comes back, and a stranger's file is judged first."""

from __future__ import annotations

import io
import os
import struct
import zipfile
import zlib
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import pyuff
from hostile_npz import bomb, twice
from scipy.io import savemat

from rolling.archive.mat_file import mat_variables, read_mat_array
from rolling.recordings.series_files import FileLayout, MeasuredSeries, read_series
from rolling.terminal.whole_files import FolderError

RATE = 12_000
SAMPLES = np.random.default_rng(1).standard_normal(6000)
TIMES = np.arange(len(SAMPLES)) / RATE
LIMITS = {"most_bytes": 2_000_000, "most_sample_bytes": 500_000}


def read(path: Path, *names: str, rate_hz: float | None = None) -> MeasuredSeries:
    return read_series(path, FileLayout(names, rate_hz), **LIMITS)


def mat(packed: bool = False, **variables: object) -> bytes:
    """Return a file of MATLAB."""
    stream = io.BytesIO()
    savemat(stream, variables, do_compression=packed)
    return stream.getvalue()


def npz(packed: bool = False, **arrays: np.ndarray) -> bytes:
    """Return an archive of numpy."""
    stream = io.BytesIO()
    (np.savez_compressed if packed else np.savez)(stream, **arrays)
    return stream.getvalue()


def uff(path: Path, binary: int, number_of_sets: int = 1) -> None:
    """Write functions of time into a file of UFF."""
    for number in range(number_of_sets):
        function = pyuff.prepare_58(
            binary=binary,
            func_type=1,
            rsp_node=1,
            rsp_dir=3,
            ref_dir=3,
            ref_node=1,
            ver_num=0,
            load_case_id=0,
            data=SAMPLES,
            x=TIMES,
            id1=f"sensor {number}",
            rsp_ent_name="a",
            ref_ent_name="b",
            abscissa_spacing=1,
            abscissa_spec_data_type=17,
            ordinate_spec_data_type=12,
            orddenom_spec_data_type=0,
            z_axis_spec_data_type=0,
            abscissa_inc=1 / RATE,
            abscissa_min=0.0,
            z_axis_value=0.0,
            num_pts=len(TIMES),
            ord_data_type=4,
            return_full_dict=True,
        )
        for key, value in function.items():
            if value is None:
                function[key] = 0 if key.endswith("exp") else "NONE"
        pyuff.UFF(str(path)).write_sets(function, "add")


@pytest.mark.parametrize("packed", [False, True])
def test_a_series_comes_back(tmp_path: Path, packed: bool) -> None:
    """A scalar beside it is no series, and texts, structures and objects are left alone."""
    path = tmp_path / "a.mat"
    path.write_bytes(
        mat(packed, X097_DE_time=SAMPLES[:, None], X097RPM=1797, s={"a": 1}, t="text", c=1j)
    )
    assert np.array_equal(read(path, rate_hz=RATE).samples[:, 0], SAMPLES)
    path = tmp_path / "a.npz"
    path.write_bytes(npz(packed, DE=SAMPLES.astype("f4")[:, None], rpm=np.array(1797)))
    assert read(path, rate_hz=RATE).samples[:, 0] == pytest.approx(SAMPLES, rel=1e-6)


@pytest.mark.parametrize(("separator", "head"), [(",", "time,acc"), (";", ""), ("\t", "# made")])
def test_columns_come_back_with_the_rate_of_their_times(
    tmp_path: Path, separator: str, head: str
) -> None:
    path = tmp_path / "a.csv"
    columns = np.stack([TIMES, SAMPLES], 1)
    np.savetxt(path, columns, delimiter=separator, header=head, comments="")
    series = read(path)
    assert series.rate_hz == pytest.approx(RATE)
    assert series.samples[:, 0] == pytest.approx(SAMPLES)


@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")  # pyuff writes
@pytest.mark.parametrize("binary", [0, 1])
def test_functions_of_time_come_back(tmp_path: Path, binary: int) -> None:
    path = tmp_path / "a.uff"
    uff(path, binary, number_of_sets=2)
    series = read(path, "sensor 1", "sensor 0")
    assert series.samples.shape == (len(SAMPLES), 2)
    assert series.samples[:, 0] == pytest.approx(SAMPLES, rel=1e-5)
    assert series.rate_hz == pytest.approx(RATE, rel=1e-4)


def test_what_is_in_a_file_is_said(tmp_path: Path) -> None:
    path = tmp_path / "a.npz"
    path.write_bytes(npz(DE=SAMPLES, FE=SAMPLES, rows=np.stack([SAMPLES, 2 * SAMPLES])))
    with pytest.raises(FolderError, match=r"got 4 series.*DE \(6,000 numbers\), FE"):
        read(path)
    with pytest.raises(FolderError, match=r"--variable: got sensor; .* has DE"):
        read(path, "sensor", rate_hz=RATE)
    with pytest.raises(FolderError, match="no sample rate in it; give it by --rate"):
        read(path, "DE")
    both = read(path, "rows:2", "DE", rate_hz=RATE).samples
    assert np.array_equal(both, np.stack([2 * SAMPLES, SAMPLES], 1))
    csv = tmp_path / "a.csv"
    np.savetxt(csv, np.stack([TIMES, SAMPLES], 1), delimiter=",")
    with pytest.raises(FolderError, match="got sample rates of 12000 and 48000 Hz"):
        read(csv, rate_hz=48_000)


# ---- strangers' files


def longer(content: bytes, count: int) -> bytes:
    """Return a file of MATLAB whose only variable says that it has more numbers."""
    place = content.index(struct.pack("<ii", len(SAMPLES), 1))
    return content[:place] + struct.pack("<ii", count, 1) + content[place + 8 :]


def packed_bomb() -> bytes:
    """Return a small file of MATLAB that says it becomes a gigabyte."""
    whole = mat(x=SAMPLES[:, None])
    size = 10**9
    element = struct.pack("<II", 14, size) + whole[136:]
    element = zlib.compress(element + bytes(10**7))
    return whole[:128] + struct.pack("<II", 15, len(element)) + element


WHOLE = mat(x=SAMPLES[:, None])
HOSTILE_MAT: dict[str, tuple[Callable[[], bytes], str]] = {
    "cut off": (lambda: WHOLE[:-100], "not whole"),
    "cut in its head": (lambda: WHOLE[:100], "head is missing"),
    "of another version": (lambda: WHOLE[:124] + b"\x00\x02IM" + WHOLE[128:], "version 7.3"),
    "no file of MATLAB": (lambda: b"PK" + bytes(5000), "head is missing"),
    "more numbers than it has": (lambda: longer(WHOLE, 10**8), "another size"),
    "a negative length": (lambda: longer(WHOLE, -5), "nothing of numbers"),
    "a bomb": (packed_bomb, "1,000,000,008 bytes, allowed: 500,000"),
    "two variables of one name": (lambda: WHOLE + WHOLE[128:], "two variables with the name 'x'"),
    "objects alone": (lambda: mat(x=np.array([{}, "a"], object)), "nothing of numbers"),
    "structures alone": (lambda: mat(x={"y": {"z": SAMPLES}}), "nothing of numbers"),
    "complex numbers": (lambda: mat(x=1j * SAMPLES), "nothing of numbers"),
    "damaged where packed": (
        lambda: mat(True, x=SAMPLES[:, None])[:500] + bytes(2000),
        "no series that can be read",
    ),
}


@pytest.mark.parametrize("name", HOSTILE_MAT)
def test_a_strangers_mat_is_refused(tmp_path: Path, name: str) -> None:
    make, words = HOSTILE_MAT[name]
    path = tmp_path / "a.mat"
    path.write_bytes(make())
    with pytest.raises(FolderError, match=words):
        read(path, rate_hz=RATE)


def test_each_byte_of_a_description_may_be_wrong() -> None:
    """A file reads as it is, or is refused as a wrong value; nothing else happens."""
    small = mat(x=np.arange(30.0)[:, None], y=np.arange(3.0))
    packed = mat(True, x=np.arange(30.0)[:, None])
    for content in (small, packed):
        for place in range(120, min(len(content), 420)):
            for value in (0x00, 0x0F, 0x80, 0xFF):
                wrong = bytearray(content)
                wrong[place] = value
                try:
                    for variable in mat_variables(bytes(wrong), 10_000):
                        if variable.count:
                            read_mat_array(bytes(wrong), variable)
                except ValueError:
                    pass


def renamed(content: bytes) -> bytes:
    """Return an archive with a member that is no array."""
    stream = io.BytesIO(content)
    with zipfile.ZipFile(stream, "a") as archive:
        archive.writestr("run.py", "print('no')")
    return stream.getvalue()


@pytest.mark.filterwarnings("ignore:Duplicate name")
@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda whole: whole[:200], "no series that can be read"),
        (lambda whole: bomb(whole, "x"), "another size than it says"),
        (lambda whole: twice(whole, "x"), "two arrays with the name 'x'"),
        (lambda _: npz(x=np.array([{}] * 2000, object)), "nothing of numbers|no series|got 0"),
        (lambda _: npz(True, x=np.zeros(10**6)), "8,000,128 bytes, allowed: 500,000"),
        (lambda _: npz(x=SAMPLES + 1j), "got 0 series"),
    ],
)
def test_a_strangers_archive_is_refused(
    tmp_path: Path, make: Callable[[bytes], bytes], words: str
) -> None:
    path = tmp_path / "a.npz"
    path.write_bytes(make(npz(x=SAMPLES)))
    with pytest.raises(FolderError, match=words):
        read(path, rate_hz=RATE)


def test_a_member_that_is_no_array_is_left_alone(tmp_path: Path) -> None:
    path = tmp_path / "a.npz"
    path.write_bytes(renamed(npz(x=SAMPLES)))
    assert len(read(path, rate_hz=RATE).samples) == len(SAMPLES)


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("a.csv", b"time,acc\n1,2\n3,x\n", "no series that can be read"),
        ("a.csv", b"", "no series that can be read"),
        ("a.csv", b"a,a\n1,2\n", "two columns with one name"),
        ("a.csv", b"1\n2\n", "got 0 series"),
        ("a.uff", b"    -1\n    58\n" + b"x" * 500, "no series that can be read|got 0 series"),
        ("a.uff", bytes(1000), "no series that can be read|got 0 series"),
    ],
)
def test_a_strangers_text_is_refused(tmp_path: Path, name: str, content: bytes, words: str) -> None:
    path = tmp_path / name
    path.write_bytes(content)
    with pytest.raises(FolderError, match=words):
        read(path, rate_hz=RATE)


def test_other_things_than_files_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "a.mat"
    with pytest.raises(FolderError, match="not readable"):
        read(path, rate_hz=RATE)
    os.mkfifo(path)
    with pytest.raises(FolderError, match="is a pipe"):
        read(path, rate_hz=RATE)
    large = tmp_path / "large.csv"
    large.write_bytes(bytes(LIMITS["most_bytes"] + 1))
    with pytest.raises(FolderError, match="is larger than 2,000,000 bytes"):
        read(large, rate_hz=RATE)
