"""Errors of any kind that say that the system refused memory."""

import errno
from collections.abc import Iterator
from contextlib import contextmanager

NOT_ENOUGH = "not enough memory"  # the beginning of each sentence about it
WORDS = f"{NOT_ENOUGH}; take fewer workers or nodes, or allow more (`ulimit -v`)"
# A library that does not fit is an ImportError, and a thread whose stack does not fit is a
# RuntimeError. Only words of the error tell the reason.
_WORDS_OF_ERRORS = (
    "failed to map segment",
    "cannot allocate memory",
    "can't start new thread",
    "memory allocation failed",
    "unable to allocate",
)


def is_of_memory(error: BaseException | None) -> bool:
    """Tell whether an error, or one that it comes from, says that memory was refused."""
    while error is not None:
        if _says_memory(error):
            return True
        if error.__cause__ is not None or error.__suppress_context__:
            error = error.__cause__
        else:
            error = error.__context__
    return False


def _says_memory(error: BaseException) -> bool:
    """Tell whether an error itself says that memory was refused."""
    if isinstance(error, MemoryError) or getattr(error, "errno", None) == errno.ENOMEM:
        return True
    text = str(error).lower()
    if "not permitted" in text or "permission denied" in text:
        return False  # a library on a disk that runs no programs cannot be mapped either
    return any(words in text for words in _WORDS_OF_ERRORS)


def sentence(error: BaseException) -> str:
    """Say that memory was refused, with the words of the error if it has others."""
    text = str(error)
    if text.startswith(NOT_ENOUGH):
        return text
    if not text:
        return WORDS
    return f"{WORDS} ({text})"


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
