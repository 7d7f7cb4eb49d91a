"""Sound from a released power or a force: levels, spectra, weighting, uncertainty, WAVs, plots.

The package works on arrays and sample rates and knows nothing about contact. Public names, which
the stub `__init__.pyi` lists, are imported when they are first used, so ``import acoustics`` takes
no time.

>>> import numpy as np
>>> import acoustics
>>> tone = np.sqrt(2) * np.sin(2 * np.pi * 1000 * np.arange(48000) / 48000)  # 1 Pa rms
>>> round(acoustics.laeq_db(tone, 48000), 2)
93.98
"""

import ast
from importlib import import_module
from inspect import isfunction
from pathlib import Path
from typing import Any

__distribution__ = "rolling-contact-noise"  # tells this package from others of its name

_STUB = ast.parse(Path(__file__).with_suffix(".pyi").read_text(encoding="utf-8"))
_MODULES = {
    alias.name: str(node.module)
    for node in _STUB.body
    if isinstance(node, ast.ImportFrom)
    for alias in node.names
}

__all__ = sorted(_MODULES)


def __getattr__(name: str) -> Any:
    """Import a public name when it is first used; a function ignores underflow from here on."""
    if name not in _MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    module = _MODULES[name]
    if module == __name__:
        return import_module(f"{module}.{name}")
    value = getattr(import_module(module), name)
    if isfunction(value):
        value = import_module(f"{__name__}.traps").ignoring_underflow(value)
        value.__module__ = __name__  # where pickle finds it
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    """List the public names, for completion."""
    return sorted({*globals(), *__all__})
