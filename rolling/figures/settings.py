"""Settings of pictures in files, which depend on nothing around them, and pictures that fail."""

import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import matplotlib

from rolling.terminal import shortage


class PictureWarning(UserWarning):
    """Warning of a picture that could not be drawn and is left out."""


@contextmanager
def own_settings() -> Iterator[None]:
    """Draw with the defaults of matplotlib in this context, or in the function that it decorates.

    The settings of the process are kept and come back: those of matplotlibrc, of styles and of
    rcParams. The backend stays as it is, because files are drawn by a canvas of their own.
    """
    with matplotlib.rc_context():
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", matplotlib.MatplotlibDeprecationWarning)
            defaults: Any = {
                name: matplotlib.rcParamsDefault[name]
                for name in matplotlib.rcParamsDefault
                if name != "backend"
            }
            matplotlib.rcParams.update(defaults)
        yield


@contextmanager
def left_out_if_it_fails(name: str) -> Iterator[None]:
    """Go on where the picture of a name cannot be drawn in this context, with a warning.

    A run is not worth less for it. Lack of memory ends a run as everywhere else.
    """
    try:
        yield
    except Exception as error:
        if shortage.is_of_memory(error):
            raise
        reason = f"{type(error).__name__}: {error}".splitlines()[0]
        warnings.warn(
            f"the picture {name} is left out, because it could not be drawn ({reason})",
            PictureWarning,
            stacklevel=3,
        )
