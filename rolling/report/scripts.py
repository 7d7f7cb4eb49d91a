"""Scripts of the page: ES modules that import each other by name, joined into one text."""

import re
from importlib.resources import files

_IMPORT = re.compile(r'^import \{[^}]*\} from "(\./|\.\./)([\w/]+\.js)";\n', re.MULTILINE)


def joined(entry: str) -> str:
    """Join a module of `assets/` with all modules that it imports, each once, imports first.

    The modules then share a scope, so no two of them may declare the same name at their top level.
    """
    parts: dict[str, str] = {}
    _gather(entry, parts)
    return "\n".join(parts.values())


def _gather(name: str, parts: dict[str, str]) -> None:
    """Add the text of a module to the parts behind the texts of the modules that it imports."""
    text = files("rolling.report").joinpath("assets", *name.split("/")).read_text("utf-8")
    parts[name] = ""  # a module that imports one that imports it is not read again
    room = name.rpartition("/")[0]
    for above, imported in _IMPORT.findall(text):
        path = f"{room}/{imported}" if above == "./" else imported
        if path not in parts:
            _gather(path, parts)
    del parts[name]
    parts[name] = re.sub(r"^export ", "", _IMPORT.sub("", text), flags=re.MULTILINE)
