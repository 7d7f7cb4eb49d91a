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
PACKAGES = ("rolling", "acoustics")
# Objects that a user receives without an import.
RECEIVED = {
    "Run": "rolling.results.run_result.Run",
    "Run.sound": "rolling.sound.contact_sound.ContactSound",
    "Run.sound.levels": "acoustics.level.SoundLevels",
    "Run.vibration": "rolling.sound.vibration_sound.Vibration",
    "Scene, in SI": "rolling.scene.quantities.SceneQuantities",
    "Scene.check()": "rolling.check.findings.Findings",
}

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


def api_page():
    """Return the Markdown of the API page: the exported names, and objects that a user receives."""
    lines = [
        "# API",
        "",
        "All arguments and results are in SI units unless a name carries its unit.",
        "",
    ]
    tables = {package: exported_names(package) for package in PACKAGES}
    shown = dict.fromkeys(path for names in tables.values() for path in names.values())
    tables["Objects that functions return"] = RECEIVED
    for heading, names in tables.items():
        prefix = f"{heading}." if heading in PACKAGES else ""
        lines += [f"## {heading}", "", "| name | is |", "|---|---|"]
        lines += [f"| `{prefix}{name}` | [`{path}`][{path}] |" for name, path in names.items()]
        lines += [""]
        for path in names.values():
            if heading in PACKAGES or path not in shown:
                lines += [f"::: {path}", ""]
    return "\n".join(lines)
