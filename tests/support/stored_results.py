"""Results are compared to the last bit, and files of results are refused with a message."""

from __future__ import annotations

from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rolling.folders.files import FolderError
from rolling.simulation import result_file


def same(a: Any, b: Any) -> bool:
    """Tell whether two values are equal to the last bit, NaN included, at any depth."""
    if isinstance(a, np.ndarray):
        return a.dtype == b.dtype and np.array_equal(a, b, equal_nan=a.dtype.kind == "f")
    if isinstance(a, dict):
        return a.keys() == b.keys() and all(same(a[key], b[key]) for key in a)
    if hasattr(a, "__dataclass_fields__"):
        return all(same(getattr(a, f.name), getattr(b, f.name)) for f in fields(a))
    return bool(a == b)


def refusal(path: Path) -> str:
    """Return the message that refuses a result.h5: one line, which begins with the path."""
    with pytest.raises(FolderError) as error:
        result_file.load(path)
    message = str(error.value)
    assert message.startswith(str(path)) and "\n" not in message
    return message
