"""Tutorials: notebooks of docs/tutorials/, executed when the site is built, as pages of the site.

A notebook runs again only when it or a source changes. Players become compressed files.
"""

from __future__ import annotations

import base64
import os
import re
from html import escape
from pathlib import Path

import nbclient
import nbformat
from build_cache import ROOT, cached_build, compressed
from mkdocs.structure.files import File

TUTORIALS = ROOT / "docs" / "tutorials"
INLINE = "module://matplotlib_inline.backend_inline"  # pictures as outputs, whatever is set outside
TIMEOUT_S = 900  # of a cell: the first one of a fresh clone compiles the solver
STYLE = re.compile(r'<style.*?</style>| border="1" class="dataframe"', re.DOTALL)  # of pandas
SOUND = re.compile(r'src="data:audio/wav;base64,([^"]+)"')


def on_files(files, config):
    """Add a page for each notebook, with its pictures and sounds."""
    for path in sorted(TUTORIALS.glob("*.ipynb")):
        text, parts = page(executed(path), path.stem)
        files.append(File.generated(config, f"tutorials/{path.stem}.md", content=text))
        for name, content in parts.items():
            files.append(File.generated(config, f"tutorials/{name}", content=content))
    return files


def executed(path: Path) -> nbformat.NotebookNode:
    """Return a notebook with its outputs; execute it unless it is kept with the same sources."""

    def make(part: Path) -> None:
        nbformat.write(_run(nbformat.read(path, as_version=4)), part)

    name = f"tutorials/{path.stem}"
    return nbformat.read(cached_build(name, path.read_bytes(), make), as_version=4)


def _run(notebook: nbformat.NotebookNode) -> nbformat.NotebookNode:
    """Execute a notebook, whose kernel logs errors only."""
    place = {"metadata": {"path": str(TUTORIALS)}}
    client = nbclient.NotebookClient(
        notebook, timeout=TIMEOUT_S, resources=place, extra_arguments=["--log-level=ERROR"]
    )
    return client.execute(env={**os.environ, "MPLBACKEND": INLINE})


def page(notebook: nbformat.NotebookNode, stem: str) -> tuple[str, dict[str, bytes]]:
    """Return the Markdown of an executed notebook, and its pictures and sounds by file name."""
    parts: list[str] = []
    files: dict[str, bytes] = {}
    for cell in notebook.cells:
        if cell.cell_type == "markdown":
            parts.append(cell.source)
            continue
        parts.append(f"```python\n{cell.source}\n```")
        parts += [_shown(output, stem, files) for output in cell.outputs]
    return "\n\n".join(filter(None, parts)) + "\n", files


def _shown(output: nbformat.NotebookNode, stem: str, files: dict[str, bytes]) -> str:
    """Return the Markdown of an output, and add its picture or sound to the files."""
    if output.output_type == "stream":
        return _framed(escape(output.text), "pre") if output.name == "stdout" else ""
    data = output.data
    if "image/png" in data:
        name = f"{stem}-{len(files) + 1}.png"
        files[name] = base64.b64decode(data["image/png"])
        return f"![Output of the cell above]({name})"
    if sound := SOUND.search(data.get("text/html", "")):
        name = f"{stem}-{len(files) + 1}.mp3"
        files[name] = compressed(base64.b64decode(sound[1]))
        label = 'aria-label="Sound of the cell above"'
        return f'<audio controls preload="none" {label} src="{name}"></audio>'
    if "text/html" in data:
        return _framed(STYLE.sub("", data["text/html"]))
    return _framed(escape(data["text/plain"]), "pre")


def _framed(content: str, tag: str = "div") -> str:
    """Return an output as HTML."""
    return f'<{tag} class="output">{content.strip()}</{tag}>'
