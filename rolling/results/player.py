"""Players of the sound of a run: in a notebook, or of the desktop."""

from __future__ import annotations

import os
import sys
import webbrowser
from pathlib import Path
from typing import Any

from acoustics import wav
from rolling.kinds.heard_sound import played_sound
from rolling.kinds.registry import kind_of
from rolling.terminal import progress
from rolling.terminal.whole_files import write_temporary


def play(run: Any) -> Any:
    """Return a player in a notebook; in a script, name a sound file and open a player for it.

    Raises
    ------
    ValueError : the kind of the run has no sounds.
    """
    kind = kind_of(run.scene)
    sound = played_sound(kind.sounds(run))
    if sound is None:
        raise ValueError(f"{kind.name}: runs of this kind have no sound")
    if progress.in_notebook():
        from IPython.display import Audio

        samples = sound.samples * wav.listening_gain(sound.samples)
        return Audio(samples.T, rate=wav.SAMPLE_RATE_HZ, normalize=False)
    path = run.folder / sound.file
    is_stored = run.stored is not None and path.is_file()
    if not is_stored:
        path = write_temporary(f"{run.scene.name}-listen-", ".wav", sound.wav())
    print(f"listen: {path}   {sound.words}")
    _open_player(path)
    return None


def _open_player(path: Path) -> None:
    """Play a file by the player of the desktop, where a person sits at a terminal of one."""
    has_display = {"DISPLAY", "WAYLAND_DISPLAY"} & {*os.environ}
    has_desktop = sys.platform in ("darwin", "win32") or has_display
    if has_desktop and sys.stdout.isatty() and "CI" not in os.environ:
        webbrowser.open(path.resolve().as_uri())
