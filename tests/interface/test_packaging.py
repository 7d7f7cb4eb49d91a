"""A release: pins for all that is installed, links that work on an index page, and a source
distribution and wheel that lack nothing.
"""

from __future__ import annotations

import importlib.util
import os
import re
import shutil
import subprocess
import sys
import tarfile
import tomllib
import zipfile
from importlib import metadata
from pathlib import Path
from types import ModuleType

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name
from packaging.version import Version

ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
NOT_SOURCES = (
    ".git", ".venv", "__pycache__", "build", "dist", "*.egg-info", ".*_cache", ".hypothesis",
    ".coverage", "PKG-INFO", "setup.cfg",
)  # fmt: skip


def test_constraints_pin_every_package_of_all_extras() -> None:
    """Follow what installed packages require, from the project's own list."""
    lines = (ROOT / "constraints.txt").read_text(encoding="utf-8").splitlines()
    pins = [line for line in lines if not line.startswith("#")]
    assert all(re.fullmatch(r"[\w.-]+==[\w.]+", pin) for pin in pins), "versions alone"
    pinned = {canonicalize_name(pin.partition("==")[0]) for pin in pins}
    assert len(pinned) == len(pins)
    extras = PROJECT["optional-dependencies"]
    waiting = [Requirement(text) for text in sum(extras.values(), PROJECT["dependencies"])]
    seen: set[str] = set()
    while waiting:
        requirement = waiting.pop()
        name = canonicalize_name(requirement.name)
        assert name in pinned, f"{name} is not pinned in constraints.txt"
        for extra in {"", *requirement.extras}:
            if f"{name}[{extra}]" in seen:
                continue
            seen.add(f"{name}[{extra}]")
            try:
                inner = metadata.requires(name) or []
            except metadata.PackageNotFoundError:
                continue  # of an extra that is not installed here
            parsed = [Requirement(text) for text in inner]
            waiting += [
                each for each in parsed if not each.marker or each.marker.evaluate({"extra": extra})
            ]
    assert len(seen) > 20


def test_the_lower_bounds_are_those_that_were_tried() -> None:
    page = (ROOT / "RELEASING.md").read_text(encoding="utf-8")
    (tried,) = re.findall(r"^The lower bounds are (.*?) and h5netcdf ([\d.]+),", page, re.M | re.S)
    listed = re.split(r",\s+", f"{tried[0]}, h5netcdf {tried[1]}")
    versions = dict(part.split() for part in listed)
    for text in PROJECT["dependencies"]:
        requirement = Requirement(text)
        (bound,) = [each.version for each in requirement.specifier if each.operator == ">="]
        assert Version(versions.pop(requirement.name)) == Version(bound), text
    assert not versions


# ---- the page of an index
# --------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def setup_file() -> ModuleType:
    """Return setup.py as a module, which builds nothing."""
    pytest.importorskip("setuptools", reason="the build needs setuptools")
    spec = importlib.util.spec_from_file_location("setup_file", ROOT / "setup.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_links_of_the_index_page_are_absolute_where_the_repository_is_known(
    setup_file: ModuleType,
) -> None:
    text = (
        "![a page](scenarios/a.png) [docs](docs/b.md#c), [x](examples/), [y](https://e.org/z),"
        " [here](#d)\n"
    )
    page = setup_file.index_page(text, "https://example.org/us/it/", "v1")
    place = "https://example.org/us/it"
    assert page == (
        f"![a page]({place}/raw/v1/scenarios/a.png) [docs]({place}/blob/v1/docs/b.md#c), "
        f"[x]({place}/tree/v1/examples/), [y](https://e.org/z), [here](#d)\n"
    )


def test_the_index_page_shows_a_picture_as_on_a_light_page(setup_file: ModuleType) -> None:
    picture = '<picture><source srcset="a/b-dark.svg"><img alt="a ball" src="a/b.svg"></picture>\n'
    page = setup_file.index_page(picture, "https://example.org/it", "v1")
    assert page == "![a ball](https://example.org/it/raw/v1/a/b.svg)\n"
    assert "<" not in setup_file.index_page(picture, None, "v1")
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    for path in re.findall(r'(?:src|srcset)="([^"]+)"', readme):
        assert (ROOT / path).is_file(), path


def test_the_index_page_has_no_link_that_leads_nowhere(setup_file: ModuleType) -> None:
    """Without an address of the repository the README's pictures go, and its links become text."""
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    page = setup_file.index_page(readme, None, "HEAD")
    assert setup_file.LINK.search(readme) and not setup_file.LINK.search(page)
    assert page.endswith(f"\n\n{setup_file.LAST_LINE}\n")
    assert "[" not in re.sub(r"```.*?```", "", page, flags=re.DOTALL)
    assert setup_file.index_page("no links\n", None, "HEAD") == "no links\n"


# ---- source distribution and wheel
# -----------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """Build the source distribution from a copy of this tree, and the wheel from what it unpacks
    to; return both unpacked.
    """
    setuptools = pytest.importorskip("setuptools", reason="the build needs setuptools")
    # The license of pyproject.toml is an expression with files (PEP 639), which older ones refuse.
    if int(setuptools.__version__.partition(".")[0]) < 77:
        pytest.skip("the build needs setuptools 77, which the extra `dev` installs")
    folder = tmp_path_factory.mktemp("built")
    shutil.copytree(ROOT, folder / "tree", ignore=shutil.ignore_patterns(*NOT_SOURCES))
    for output in (folder / "tree" / "outputs").iterdir():
        if output.name != ".gitkeep":
            shutil.rmtree(output) if output.is_dir() else output.unlink()
    with tarfile.open(_build("sdist", folder / "tree", folder / "sdist")) as archive:
        archive.extractall(folder / "unpacked", filter="data")
    (unpacked,) = (folder / "unpacked").iterdir()
    kept = folder / "source"
    shutil.copytree(unpacked, kept)
    with zipfile.ZipFile(_build("wheel", unpacked, folder / "wheel")) as wheel:
        wheel.extractall(folder / "site")
    return kept, folder / "site"


def _build(kind: str, tree: Path, out: Path) -> Path:
    out.mkdir()
    code = f"import sys; from setuptools import build_meta; build_meta.build_{kind}(sys.argv[1])"
    done = subprocess.run(
        [sys.executable, "-c", code, out], cwd=tree, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    (file,) = out.iterdir()
    return file


def _files(folder: Path) -> set[str]:
    return {path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()}


@pytest.mark.slow
def test_the_source_distribution_is_the_whole_repository(built: tuple[Path, Path]) -> None:
    source, _ = built
    made = {"PKG-INFO", "setup.cfg"}
    names = {name for name in _files(source) if ".egg-info/" not in name} - made
    tree = source.parent / "tree"
    assert names == {name for name in _files(tree) if ".egg-info/" not in name}


@pytest.mark.slow
def test_the_wheel_has_the_packages_and_the_scenes_and_nothing_else(
    built: tuple[Path, Path],
) -> None:
    source, site = built
    names = {name for name in _files(site) if ".dist-info/" not in name}
    modules = {name for name in _files(source) if re.match(r"(rolling|acoustics)/.*\.py$", name)}
    scenes = {
        f"rolling/{name}"
        for name in _files(source)
        if re.match(r"scenarios/(?!pictures/).*\.(yaml|json|sdf|csv|toml|jinja)$", name)
    }
    data = re.compile(r"rolling/(report/assets/.*|.*\.toml|scene/.*\.yaml)$")
    assets = {name for name in _files(source) if data.match(name)}
    typed = {
        f"{name}/{file}"
        for name in ("rolling", "acoustics")
        for file in ("py.typed", "__init__.pyi")
    }
    assert names == modules | scenes | assets | typed and len(scenes) > 30
    (info,) = site.glob("*.dist-info")
    text = (info / "METADATA").read_text(encoding="utf-8")
    assert f"Version: {PROJECT['version']}\n" in text and "# rolling-contact-noise\n" in text
    assert not re.search(r"\]\((?!https?://)", text)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("arguments", "code", "printed"),
    [
        (["scenes"], 0, "quickstart "),
        (["check", "--fast", "quickstart"], 0, "It runs"),
        (["init", "smooth"], 0, "smooth.yaml"),
        (["reproduce", "lee2025", "--readings", "none"], 2, "allowed: as-stated, "),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, list) else None,
)
def test_the_wheel_finds_its_scenes_in_an_empty_folder(
    built: tuple[Path, Path], tmp_path: Path, arguments: list[str], code: int, printed: str
) -> None:
    _, site = built
    done = subprocess.run(
        [sys.executable, "-m", "rolling", *arguments],
        env=os.environ | {"PYTHONPATH": str(site)},
        cwd=tmp_path,
        capture_output=True,
        text=True,
    )
    assert done.returncode == code and printed in done.stdout + done.stderr
