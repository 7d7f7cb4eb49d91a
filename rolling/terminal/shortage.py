"""Errors of any kind that say that the system refused memory."""

import errno
from collections.abc import Iterator
from contextlib import contextmanager

WORDS = "not enough memory; take fewer workers or nodes, or allow more (`ulimit -v`)"
# A library that does not fit is an ImportError, and a thread whose stack does not is a
# RuntimeError; only their words tell the reason.
_SIGNS = (
    "failed to map segment",
    "cannot allocate memory",
    "can't start new thread",
    "memory allocation failed",
    "unable to allocate",
)


def is_of_memory(error: BaseException | None) -> bool:
    """Tell whether an error, or one that it comes from, says that memory was refused."""
    while error is not None:
        if isinstance(error, MemoryError) or getattr(error, "errno", None) == errno.ENOMEM:
            return True
        text = str(error).lower()
        # A library on a disk that runs no programs cannot be mapped either.
        is_forbidden = "not permitted" in text or "permission denied" in text
        if not is_forbidden and any(sign in text for sign in _SIGNS):
            return True
        hidden = None if error.__suppress_context__ else error.__context__
        error = error.__cause__ or hidden
    return False


def sentence(error: BaseException) -> str:
    """Say that memory was refused, with the words of the error if it has others."""
    text = str(error)
    if text.startswith("not enough memory"):
        return text
    return f"{WORDS} ({text})" if text else WORDS


@contextmanager
def as_memory_error() -> Iterator[None]:
    """Raise MemoryError for any error in this context that says that memory was refused."""
    try:
        yield
    except MemoryError:
        raise
    except Exception as error:
        if is_of_memory(error):
            raise MemoryError(sentence(error)) from error
        raise
