"""Pages of the site that stand elsewhere in the repository, and the list of modules of the API page.

A page links to a file outside of docs/ by its path in the repository (`../CHANGELOG.md`), so that the link also works where the
repository is browsed. In the site such a link leads to the copy of that file, or becomes plain text if the site has no copy.
"""

from __future__ import annotations

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
# The rooms whose modules are documented. A module whose name begins with an underscore is private.
ROOMS = ("rolling/scene", "rolling/surface", "rolling/contact", "rolling/simulation", "rolling", "acoustics")
# The command line is described by its own help.
NOT_LISTED = {"rolling/cli.py", "rolling/commands.py"}

LINK = re.compile(r"(!?)\[([^\]]*)\]\((?:\.\./)+([^)#\s]+)(#[^)\s]*)?\)")
OWN_LINK = re.compile(r"\]\(docs/([^)\s]+)\)")


def on_files(files, config):
    """Add the pages and pictures that stand outside of docs/, and the API page."""
    for source, target in PAGES.items():
        text = (ROOT / source).read_text(encoding="utf-8")
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


def public_modules():
    """List the public modules of the documented rooms, as dotted names by room, from the files that exist."""
    return {
        room: [
            ".".join(path.relative_to(ROOT).with_suffix("").parts)
            for path in sorted((ROOT / room).glob("*.py"))
            if not path.name.startswith("_") and path.relative_to(ROOT).as_posix() not in NOT_LISTED
        ]
        for room in ROOMS
        if (ROOT / room).is_dir()
    }


def api_page():
    """Return the Markdown of the API page: one mkdocstrings block for each public module."""
    lines = ["# API", "", "All arguments and results are in SI units unless a name carries its unit.", ""]
    lines += ["The names that `rolling` and `acoustics` export are documented in the module that defines them.", ""]
    for room, modules in public_modules().items():
        lines += [f"## {room.replace('/', '.')}", ""]
        for module in modules:
            lines += [f"::: {module}", ""]
    return "\n".join(lines)
