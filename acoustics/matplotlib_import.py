"""The first import of matplotlib, whatever backend or settings file the surroundings name.

`MPLBACKEND` may name a backend that is not installed here (Jupyter exports its own to the processes
that it starts), and a file `matplotlibrc` of the working or home folder may be damaged. The import
of matplotlib raises then. This program needs neither of them, since it draws into files and onto
given axes. Modules that import matplotlib import this module before.
"""

import importlib
import locale
import os
import sys
from contextlib import chdir, suppress
from importlib.util import find_spec
from pathlib import Path

_BACKEND = "MPLBACKEND"


def ensure() -> None:
    """Import matplotlib unless this process has imported it; all variables keep their values.

    A backend of `MPLBACKEND` is taken where there is one of that name.

    Raises
    ------
    ImportError
        Matplotlib is missing or cannot be loaded.
    """
    if "matplotlib" in sys.modules:
        return
    backend = os.environ.pop(_BACKEND, None)
    try:
        try:
            _import_anew()
        # A settings file that is not text, that cannot be read, or that asks for an unknown locale.
        except (ValueError, OSError, locale.Error):
            with chdir(_own_settings_folder()):
                _import_anew()
    finally:
        if backend is not None:
            os.environ[_BACKEND] = backend
    if backend:
        matplotlib = sys.modules["matplotlib"]
        with suppress(ValueError):  # no such backend
            matplotlib.rcParams["backend"] = backend


def _import_anew() -> None:
    """Import matplotlib without the modules that an import which failed has left behind."""
    for name in [*sys.modules]:
        if name.startswith("matplotlib."):
            del sys.modules[name]
    importlib.import_module("matplotlib")


def _own_settings_folder() -> Path:
    """Return the folder of matplotlib's own matplotlibrc, which is read first in that folder."""
    spec = find_spec("matplotlib")
    if spec is None or spec.origin is None:
        raise ModuleNotFoundError("No module named 'matplotlib'", name="matplotlib")
    return Path(spec.origin).parent / "mpl-data"


ensure()
