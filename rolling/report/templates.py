"""The templates of the pages, their style and their scripts, from the folder `assets`."""

from __future__ import annotations

import re
from importlib.resources import files

import jinja2
from markupsafe import Markup

# The parts of the page's script, in their order.
SCRIPTS = (
    "core",
    "player",
    "fourier",
    "row",
    "extended",
    "choices",
    "motion",
    "contact",
    "film",
    "film_motion",
    "downloads",
    "compare",
    "abx",
    "sorting",
    "keys",
    "begin",
)


def environment() -> jinja2.Environment:
    """Return the environment of the pages, which escapes values and raises on missing values."""
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("rolling.report", "assets"),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["slug"] = slug
    environment.filters["css_text"] = _css_text
    # NaN must not reach the script of the page, because it is not JSON.
    environment.policies["json.dumps_kwargs"] = {"allow_nan": False, "separators": (",", ":")}
    return environment


def slug(label: str) -> str:
    """Write a label as part of a file's name."""
    return re.sub(r"[^A-Za-z0-9.=-]+", "_", label).strip("_")


def _css_text(text: str) -> Markup:
    """Write any text as the inside of a string of CSS, all but letters and digits as numbers."""
    return Markup(
        "".join(
            letter if letter.isascii() and letter.isalnum() else f"\\{ord(letter):06x}"
            for letter in text
        )
    )


def scripts() -> Markup:
    """Join the parts of the page's script in a scope of its own."""
    parts = "\n".join(own_text(f"{name}.js") for name in SCRIPTS)
    return Markup(f'(() => {{\n"use strict";\n{parts}}})();')


def own_text(name: str) -> Markup:
    """Read a file of the page, which is the program's own text and needs no escaping."""
    return Markup(files("rolling.report").joinpath("assets", name).read_text(encoding="utf-8"))
