"""Tutorials: notebooks of docs/tutorials/, executed when the site is built, as pages of the site.

An executed notebook is kept in build/tutorials/ under the digest of the notebook and the sources,
so that it runs again only when one of them changes. Players become compressed files.
"""

from __future__ import annotations

import base64
import hashlib
import io
import os
import re
from pathlib import Path

import nbclient
import nbformat
import soundfile
from filelock import FileLock
from mkdocs.structure.files import File

ROOT = Path(__file__).parents[2]
TUTORIALS = ROOT / "docs" / "tutorials"
KEPT = ROOT / "build" / "tutorials"
SOURCES = ("rolling/**/*.py", "acoustics/**/*.py", "scenarios/**/*.yaml", "constraints.txt")
INLINE = "module://matplotlib_inline.backend_inline"  # pictures as outputs, whatever is set outside
TIMEOUT_S = 900  # of a cell: the first one of a fresh clone compiles the solver
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
    digest = hashlib.sha256(path.read_bytes())
    for source in sorted(file for pattern in SOURCES for file in ROOT.glob(pattern)):
        digest.update(source.read_bytes())
    kept = KEPT / f"{path.stem}-{digest.hexdigest()[:16]}.ipynb"
    KEPT.mkdir(parents=True, exist_ok=True)
    with FileLock(KEPT / f"{path.stem}.lock"):  # a test and the site may want the same notebook
        if not kept.exists():
            for old in KEPT.glob(f"{path.stem}-*.ipynb"):
                old.unlink()
            nbformat.write(_run(nbformat.read(path, as_version=4)), kept)
    return nbformat.read(kept, as_version=4)


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
        return f"```text\n{output.text.rstrip()}\n```" if output.name == "stdout" else ""
    data = output.data
    if "image/png" in data:
        name = f"{stem}-{len(files) + 1}.png"
        files[name] = base64.b64decode(data["image/png"])
        return f"![Output of the cell above]({name})"
    if sound := SOUND.search(data.get("text/html", "")):
        name = f"{stem}-{len(files) + 1}.mp3"
        files[name] = _compressed(base64.b64decode(sound[1]))
        return f'<audio controls preload="none" src="{name}"></audio>'
    if "text/html" in data:
        return f'<div class="output">{data["text/html"]}</div>'
    return f"```text\n{data['text/plain']}\n```"


def _compressed(wav: bytes) -> bytes:
    """Return a WAV as MP3."""
    samples, rate = soundfile.read(io.BytesIO(wav))
    stream = io.BytesIO()
    soundfile.write(stream, samples, rate, format="MP3")
    return stream.getvalue()
