"""Results for the site that take time, kept in build/ under a digest of the sources."""

from __future__ import annotations

import hashlib
import io
import shutil
from collections.abc import Callable
from pathlib import Path

import soundfile
from filelock import FileLock

ROOT = Path(__file__).parents[2]
SOURCES = ("rolling/**/*.py", "acoustics/**/*.py", "scenarios/**/*.yaml", "constraints.txt")


def cached_build(name: str, content: bytes, make: Callable[[Path], None]) -> Path:
    """Return the file or folder of a name in build/; make it if its content or a source changed."""
    digest = hashlib.sha256(content)
    for source in sorted(file for pattern in SOURCES for file in ROOT.glob(pattern)):
        digest.update(source.read_bytes())
    path = ROOT / "build" / f"{name}-{digest.hexdigest()[:16]}"
    path.parent.mkdir(parents=True, exist_ok=True)
    with FileLock(path.with_name(f"{path.name.rpartition('-')[0]}.lock")):  # a test may want it too
        if not path.exists():
            for old in path.parent.glob(f"{path.name.rpartition('-')[0]}-*"):
                shutil.rmtree(old) if old.is_dir() else old.unlink()
            part = path.with_name(f"{path.name}-part")
            make(part)
            part.rename(path)
    return path


def compressed(wav: bytes) -> bytes:
    """Return a WAV as MP3."""
    samples, rate = soundfile.read(io.BytesIO(wav))
    stream = io.BytesIO()
    soundfile.write(stream, samples, rate, format="MP3")
    return stream.getvalue()
