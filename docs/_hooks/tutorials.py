"""Tutorials: notebooks of docs/tutorials/, stored with their outputs, as pages of the site.

    python docs/_hooks/tutorials.py [NAME...]

executes all notebooks, or those of the names, and stores their outputs: texts, tables, small
pictures and compressed sounds. Progress bars and times of execution are left out. A notebook that
warns or fails is not stored.
"""

from __future__ import annotations

import base64
import io
import os
import re
import sys
from collections.abc import Mapping
from html import escape
from pathlib import Path

import nbclient
import nbformat

ROOT = Path(__file__).parents[2]
TUTORIALS = ROOT / "docs" / "tutorials"
INLINE = "module://matplotlib_inline.backend_inline"  # pictures as outputs, whatever is set outside
TIMEOUT_S = 900  # of a cell: the first one of a fresh clone compiles the solver
MAX_PICTURE = 40_000  # bytes
COLOURS = (128, 64, 32, 16)  # of a picture, the first number with which it is small enough
SHRUNK = 0.9  # of a picture that no number makes small enough
SOUND_S = 5.0  # [s] of a sound that are stored
COMPRESSION = 0.8  # of a sound: 96 kbit/s, up to 18 kHz
STYLE = re.compile(r'<style.*?</style>| border="1" class="dataframe"', re.DOTALL)  # of pandas
SOUND = re.compile(r'src="data:audio/\w+;base64,([^"]+)"')
# A progress bar of tqdm with its moves of the cursor, and the line that tells of a compilation.
PROGRESS = re.compile(r"^(.*\d+%\|.*|compiling the solver.*|(\s|\x1b\[A)*)$")


def main(names: list[str]) -> int:
    """Execute notebooks and store them with their outputs; return the exit code."""
    paths = sorted(TUTORIALS.glob("*.ipynb"))
    unknown = {*names} - {path.stem for path in paths}
    if unknown:
        print(f"no tutorial: {', '.join(sorted(unknown))}", file=sys.stderr)
        return 2
    for path in paths:
        if names and path.stem not in names:
            continue
        print(path.relative_to(ROOT), flush=True)
        notebook = executed(path)
        if warned := warnings_of(notebook):
            print("\n".join(warned), file=sys.stderr)
            return 1
        path.write_text(nbformat.writes(tidied(notebook)) + "\n", encoding="utf-8")
    return 0


# ---- execution and storage


def executed(path: Path, changes: Mapping[str, str] | None = None) -> nbformat.NotebookNode:
    """Return a notebook with the outputs that it gives now.

    Texts of its cells are replaced by `changes` for this execution. Raises ValueError where one is
    not in the notebook.
    """
    notebook = nbformat.read(path, as_version=4)
    for old, new in (changes or {}).items():
        cells = [cell for cell in notebook.cells if old in cell.source]
        if not cells:
            raise ValueError(f"{path.name}: no cell has {old!r}")
        for cell in cells:
            cell.source = cell.source.replace(old, new)
    client = nbclient.NotebookClient(
        notebook,
        timeout=TIMEOUT_S,
        resources={"metadata": {"path": str(TUTORIALS)}},
        record_timing=False,
        extra_arguments=["--log-level=ERROR"],
    )
    return client.execute(env={**os.environ, "MPLBACKEND": INLINE})


def outputs_of(notebook: nbformat.NotebookNode) -> list[nbformat.NotebookNode]:
    """Return the outputs of all cells in their order."""
    return [output for cell in notebook.cells for output in cell.get("outputs", ())]


def warnings_of(notebook: nbformat.NotebookNode) -> list[str]:
    """Return what the cells wrote to standard error, except for progress."""
    lines = []
    for output in outputs_of(notebook):
        if output.output_type == "stream" and output.name == "stderr":
            lines += re.split(r"[\r\n]", output.text)
    return [line for line in lines if not PROGRESS.match(line)]


def tidied(notebook: nbformat.NotebookNode) -> nbformat.NotebookNode:
    """Return an executed notebook as it is stored, with small outputs that change when facts do."""
    notebook.metadata.language_info = {"name": "python"}  # without the version of Python
    for cell in notebook.cells:
        cell.metadata = {}
        if cell.cell_type == "code":
            cell.outputs = [_stored(output) for output in _joined(cell.outputs)]
    return notebook


def _joined(outputs: list[nbformat.NotebookNode]) -> list[nbformat.NotebookNode]:
    """Return the outputs of a cell without progress, and with adjacent texts as one.

    Into how many parts a text falls depends on the time that the cell takes.
    """
    joined: list[nbformat.NotebookNode] = []
    for output in outputs:
        is_text = output.output_type == "stream"
        if is_text and output.name == "stderr":  # of which only progress is left
            continue
        if is_text and joined and joined[-1].output_type == "stream":
            joined[-1].text += output.text
        else:
            joined.append(output)
    return joined


def _stored(output: nbformat.NotebookNode) -> nbformat.NotebookNode:
    """Return an output with a smaller picture or sound."""
    data = output.get("data", {})
    output.pop("metadata", None)
    if "data" in output:
        output.metadata = {}
    if "image/png" in data:
        content = base64.b64decode(data["image/png"])
        data["image/png"] = base64.b64encode(_small_picture(content)).decode()
    if sound := SOUND.search(data.get("text/html", "")):
        content = base64.b64encode(_compressed(base64.b64decode(sound[1]))).decode()
        source = f"data:audio/mpeg;base64,{content}"
        data["text/html"] = f'<audio controls preload="none" src="{source}"></audio>'
        data["text/plain"] = "A player of the sound"
    return output


def _small_picture(png: bytes) -> bytes:
    """Return a PNG with as many colours, and then as many pixels, as its size allows."""
    from PIL import Image

    image = Image.open(io.BytesIO(png)).convert("RGB")
    while True:
        for colours in COLOURS:
            stream = io.BytesIO()
            image.quantize(colours).save(stream, format="PNG", optimize=True)
            if stream.tell() < MAX_PICTURE:
                return stream.getvalue()
        image = image.resize((round(SHRUNK * image.width), round(SHRUNK * image.height)))


def _compressed(wav: bytes) -> bytes:
    """Return the first seconds of a WAV as MP3; of a stereo record the mean of both channels."""
    import soundfile

    samples, rate = soundfile.read(io.BytesIO(wav), always_2d=True)
    stream = io.BytesIO()
    soundfile.write(
        stream,
        samples[: round(SOUND_S * rate)].mean(axis=1),
        rate,
        format="MP3",
        bitrate_mode="CONSTANT",
        compression_level=COMPRESSION,
    )
    return stream.getvalue()


# ---- pages of the site


def on_files(files, config):
    """Add a page for each stored notebook, with its pictures and sounds."""
    from mkdocs.structure.files import File

    for path in sorted(TUTORIALS.glob("*.ipynb")):
        text, parts = page(nbformat.read(path, as_version=4), path.stem)
        files.append(File.generated(config, f"tutorials/{path.stem}.md", content=text))
        for name, content in parts.items():
            files.append(File.generated(config, f"tutorials/{name}", content=content))
    return files


def page(notebook: nbformat.NotebookNode, stem: str) -> tuple[str, dict[str, bytes]]:
    """Return the Markdown of a notebook, and its pictures and sounds by file name."""
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
        return _framed(escape(output.text), "pre")
    data = output.data
    if "image/png" in data:
        name = f"{stem}-{len(files) + 1}.png"
        files[name] = base64.b64decode(data["image/png"])
        return f"![Output of the cell above]({name})"
    if sound := SOUND.search(data.get("text/html", "")):
        name = f"{stem}-{len(files) + 1}.mp3"
        files[name] = base64.b64decode(sound[1])
        label = 'aria-label="Sound of the cell above"'
        return f'<audio controls preload="none" {label} src="{name}"></audio>'
    if "text/html" in data:
        return _framed(STYLE.sub("", data["text/html"]))
    return _framed(escape(data["text/plain"]), "pre")


def _framed(content: str, tag: str = "div") -> str:
    """Return an output as HTML."""
    return f'<{tag} class="output">{content.strip()}</{tag}>'


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
