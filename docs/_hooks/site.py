"""Pages of the site that stand elsewhere in the repository, and the API page.

A page links to a file outside of docs/ by its path in the repository (`../CHANGELOG.md`), so that
the link also works where the repository is browsed. In the site such a link leads to the copy of
that file, or becomes plain text if the site has no copy.
"""

from __future__ import annotations

import ast
import re
from pathlib import Path

from mkdocs.structure.files import File

ROOT = Path(__file__).parents[2]
PAGES = {
    "CHANGELOG.md": "changelog.md",
    "CONTRIBUTING.md": "contributing.md",
    "acoustics/CONFORMANCE.md": "conformance.md",
}
PICTURES = "scenarios/pictures/"
# The rooms whose modules are documented where a package exports no names. A module whose name
# begins with an underscore is private.
ROOMS = {
    "rolling": (
        "rolling/scene",
        "rolling/surface",
        "rolling/contact",
        "rolling/simulation",
        "rolling",
    ),
    "acoustics": ("acoustics",),
}
# The command line is described by its own help.
NOT_LISTED = {"rolling/actions.py", "rolling/cli.py"}

LINK = re.compile(r"(!?)\[([^\]]*)\]\((?:\.\./)+([^)#\s]+)(#[^)\s]*)?\)")
OWN_LINK = re.compile(r"\]\(docs/([^)\s]+)\)")


def on_files(files, config):
    """Add the pages and pictures that stand outside of docs/, and the API page."""
    for source, target in PAGES.items():
        text = (ROOT / source).read_text(encoding="utf-8")
        for page, copy in PAGES.items():
            text = text.replace(f"]({page})", f"]({copy})")
        files.append(File.generated(config, target, content=OWN_LINK.sub(r"](\1)", text)))
    for picture in sorted((ROOT / PICTURES).glob("*.png")):
        files.append(File.generated(config, f"pictures/{picture.name}", abs_src_path=str(picture)))
    files.append(File.generated(config, "api.md", content=api_page()))
    return files


def on_page_markdown(markdown, page, config, files):
    """Turn links to files of the repository into links within the site."""
    return LINK.sub(_within_site, markdown)


def _within_site(match):
    picture, text, path, anchor = match.groups()
    if path.startswith(PICTURES):
        return f"{picture}[{text}](pictures/{Path(path).name})"
    if path in PAGES:
        return f"[{text}]({PAGES[path]}{anchor or ''})"
    return text


def exported_names(package):
    """List the names that a package exports, with their full paths.

    Public names are imported lazily at run time; for editors the same imports stand under
    `TYPE_CHECKING`.
    """
    module = ast.parse((ROOT / package / "__init__.py").read_text(encoding="utf-8"))
    names = {}
    for node in ast.walk(module):
        if isinstance(node, ast.ImportFrom) and (node.module or "").split(".")[0] == package:
            names |= {
                alias.asname or alias.name: f"{node.module}.{alias.name}" for alias in node.names
            }
    return {name: path for name, path in names.items() if not name.startswith("_")}


def public_modules(room):
    """List the public modules of a room, as dotted names, from the files that exist."""
    paths = [path.relative_to(ROOT) for path in sorted((ROOT / room).glob("*.py"))]
    return [
        ".".join(path.with_suffix("").parts)
        for path in paths
        if not path.name.startswith("_") and path.as_posix() not in NOT_LISTED
    ]


def api_page():
    """Return the Markdown of the API page.

    A package is listed by its exported names, or by its modules where it exports none.
    """
    lines = [
        "# API",
        "",
        "All arguments and results are in SI units unless a name carries its unit.",
        "",
    ]
    for package, rooms in ROOMS.items():
        exported = exported_names(package)
        lines += [f"## {package}", ""]
        if exported:
            lines += ["| name | is |", "|---|---|"]
            lines += [
                f"| `{package}.{name}` | [`{path}`][{path}] |" for name, path in exported.items()
            ]
            lines += [""]
        paths = exported.values() or [module for room in rooms for module in public_modules(room)]
        for path in dict.fromkeys(paths):
            lines += [f"::: {path}", ""]
    return "\n".join(lines)
