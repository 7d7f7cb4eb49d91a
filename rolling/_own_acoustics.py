"""The check that the package `acoustics` is the one that belongs to this program.

Another distribution on the package index installs a package of that name. In one environment the
two overwrite each other's files, and uninstalling either breaks both.
"""

from importlib.util import find_spec

_MARK = b'__distribution__ = "rolling-contact-noise"'  # stands in acoustics/__init__.py


def foreign_package() -> str | None:
    """Return a message if another package, or none, would be imported as `acoustics`.

    The file is read and not imported: a foreign package may take seconds, or fail for reasons of
    its own.
    """
    spec = find_spec("acoustics")
    if spec is None:
        state = "is missing"
    elif spec.origin is None:  # a folder without __init__.py
        places = ", ".join(spec.submodule_search_locations or ())
        state = f"in {places} is incomplete"
    elif _is_foreign(spec.loader, spec.origin):
        state = f"in {spec.origin} belongs to another project"
    else:
        return None
    return (
        f"the package acoustics {state}; rolling-contact-noise brings its own and needs an"
        " environment of its own: make one (python -m venv) and install only it there"
    )


def _is_foreign(loader: object, origin: str) -> bool:
    """Return whether the source of a module lacks the mark; a loader without sources is trusted."""
    read = getattr(loader, "get_data", None)
    return read is not None and origin.endswith(".py") and _MARK not in read(origin)
