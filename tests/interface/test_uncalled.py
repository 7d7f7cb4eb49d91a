"""Every function of the program is called by the program, or is public and has docs."""

from __future__ import annotations

import inspect
import re
from pathlib import Path
from typing import Any

import jinja2
from vulture import Vulture

import acoustics
import rolling as rc
from rolling.run import worker
from rolling.scene.messages import table

ROOT = Path(__file__).parents[2]
KINDS = ("class", "function", "method", "property")

# Decorators by which a library calls a function: pydantic judges values, numba compiles.
HOOKED = [
    "@model_validator*",
    "@field_validator*",
    "@pydantic.field_validator*",
    "@overload*",
    "@intrinsic*",
    "@register_model*",
    "@infer_getattr*",
    "@type_callable*",
    "@lower_*",
]
# Methods that a library calls by their names, each with the library.
HOOKS = {
    "_repr_html_": "IPython shows an object in a notebook",
    "on_start": "numba tells a listener that it compiles",
    "on_end": "numba tells a listener that it has compiled",
    "generic_resolve": "numba asks for the type of an attribute",
    "writelines": "io.TextIOBase writes lines through it",
    "load_bytecode": "jinja2 asks for the code of a template",
    "dump_bytecode": "jinja2 hands over the code of a template",
    "__getattr__": "Python asks a module for a name that it lacks",
    "__dir__": "Python lists the names of a module",
    "__call__": "Python calls an object",
}


def of_docs() -> set[str]:
    """Return the words of README, docs, tutorials and examples."""
    pages = [ROOT / "README.md"]
    for pattern in ("docs/**/*.md", "docs/**/*.ipynb", "examples/*.py"):
        pages += ROOT.glob(pattern)
    return {word for page in pages for word in re.findall(r"\w+", page.read_text("utf-8"))}


def public_names(package: Any) -> set[str]:
    """Return the names that a package exports, all members of its modules, and those of its classes
    that the docs have.
    """
    words = of_docs()
    names = set(package.__all__)
    for name in package.__all__:
        exported = getattr(package, name)
        members = {member for member in dir(exported) if not member.startswith("_")}
        if inspect.ismodule(exported):
            names |= members
        elif inspect.isclass(exported):
            names |= members & words
    return names


def of_templates() -> set[str]:
    """Return the names that the templates of the page use."""
    names = set()
    lexer = jinja2.Environment(autoescape=True)
    for path in (ROOT / "rolling/report/assets").rglob("*.html"):
        for _, kind, value in lexer.lex(path.read_text("utf-8")):
            if kind == "name":
                names.add(value)
    return names


def of_tables() -> set[str]:
    """Return the functions that tables of the program name."""
    statements = table("rolling.studies", "lee2025_statements")["statement"]
    return {statement["condition"]["name"] for statement in statements}


def of_other_processes() -> set[str]:
    """Return the functions that a process calls by a name in the code that it is started with."""
    calls = re.findall(r"f\"(\w+)\(", inspect.getsource(worker))
    return {*calls, *worker.COMPILED_AHEAD}


def uncalled(*folders: Path, known: set[str]) -> list[str]:
    """Return the functions, methods and classes that nothing in some folders names."""
    finder = Vulture(ignore_decorators=HOOKED)
    finder.scavenge([str(folder) for folder in folders])
    # Known names are left out here: vulture would match each name with each of them as a pattern.
    named = {*HOOKS, *known}
    items = [item for item in finder.get_unused_code(min_confidence=60) if item.name not in named]
    return [
        f"{item.filename}:{item.first_lineno}: {item.name}" for item in items if item.typ in KINDS
    ]


def test_the_program_calls_all_its_functions() -> None:
    known = public_names(rc) | public_names(acoustics)
    known |= of_templates() | of_tables() | of_other_processes()
    assert uncalled(ROOT / "rolling", ROOT / "acoustics", known=known) == []


def test_a_function_that_nobody_calls_is_found(tmp_path: Path) -> None:
    text = "def used():\n    pass\n\ndef forgotten():\n    pass\n\nused()\n"
    (tmp_path / "room.py").write_text(text, encoding="utf-8")
    (found,) = uncalled(tmp_path, known=set())
    assert found.endswith("room.py:4: forgotten")
