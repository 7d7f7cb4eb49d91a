"""Imports go down the floors, acoustics stands alone, and a help text loads little."""

from __future__ import annotations

import ast
import importlib
import re
import subprocess
import sys
from collections.abc import Iterator, Sequence
from functools import cache
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest
from source_trees import tree_of

ROOT = Path(__file__).parents[2]

# A room is a file or folder at the top of a package. A room imports rooms of lower floors only, so
# a new room needs a floor.
FLOORS = {
    "rolling": (
        ("_own_acoustics", "contact", "numbers", "terminal"),
        ("archive", "bearing", "dynamics", "surface"),
        ("scene", "sound"),
        ("in_si", "kinds"),
        ("check",),
        ("marches",),
        ("results",),
        ("figures", "recordings", "run"),
        ("report",),
        ("choice", "commands", "studies"),
        ("ball_kinds", "bearing_kind", "plain_kind"),
        ("cli", "interface", "plot"),
    ),
    "acoustics": (
        ("arrays", "matplotlib_import", "numbers", "texts", "traps"),
        ("bands", "loss_factors", "pairs", "tone_window", "weighting"),
        ("radiation",),
        (
            "continued_rows",
            "loudness_steps",
            "plate_modes",
            "plot_style",
            "rectangular_plate",
            "resampling",
            "spectrum",
        ),
        (
            "level",
            "loudness",
            "modulation",
            "ring_velocity",
            "ritz_plate",
            "room",
            "sound_power",
            "unbaffled",
        ),
        ("audibility", "ears", "laps", "plots", "uncertainty", "vibration_level", "wav"),
        ("impulsiveness",),
    ),
}
# Methods of public objects that call a function of a higher room. Nothing else climbs.
CLIMBING = {
    "rolling.kinds.shown_run": {"ShownRun.play", "ShownRun.plot", "ShownRun.save"},
    "rolling.scene.swept": {"SweptScene.check"},
    "rolling.scene.values_in_si": {"SceneQuantities.length_need"},
}
FRONT_DOOR = "__init__"  # hands out names of every floor; rooms take version and place from it only
HEAVY = ("h5py", "matplotlib", "numba", "numpy", "pydantic", "scipy", "soundfile", "xarray")


@cache
def modules(package: str) -> dict[str, Path]:
    """Return the files of a package by the names of their modules."""
    files = sorted((ROOT / package).rglob("*.py"))
    names = [
        ".".join(file.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__")
        for file in files
    ]
    return dict(zip(names, files, strict=True))


@cache
def imported(module: str, for_types: bool = True) -> tuple[str, ...]:
    """Return the dotted names that a module imports, at its top, inside functions and for types.

    Methods that may climb are left out, with the types that they return.
    """
    path = modules(module.split(".")[0])[module]
    names: list[str] = []
    left_out: list[ast.stmt] = []
    statements = tree_of(path).body
    if not for_types or module in CLIMBING:
        left_out += [node for node in statements if _is_for_types(node)]
    climbing = CLIMBING.get(module, set())
    for node in statements:
        if isinstance(node, ast.ClassDef):
            left_out += [part for part in node.body if f"{node.name}.{name_of(part)}" in climbing]
    for node in walked(statements, without=left_out):
        if isinstance(node, ast.Import):
            names += [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}:{node.lineno}: relative imports are not followed here"
            names += [f"{node.module}.{alias.name}" for alias in node.names]
    return tuple(names)


def walked(statements: Sequence[ast.stmt], without: Sequence[ast.stmt]) -> Iterator[ast.AST]:
    """Yield statements and all that is in them, but for some statements and what is in those."""
    skipped = {id(node) for node in without}
    rest: list[ast.AST] = list(statements)
    while rest:
        node = rest.pop()
        if id(node) not in skipped:
            yield node
            rest += ast.iter_child_nodes(node)


def name_of(node: ast.stmt) -> str:
    """Return the name of a function or class, nothing for another statement."""
    return getattr(node, "name", "")


def _is_for_types(node: ast.stmt) -> bool:
    """Return whether a statement is `if TYPE_CHECKING:`."""
    return isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING"


def room(name: str) -> str:
    """Return the room of a dotted name.

    Names that a package defines itself belong to its front door.
    """
    package, _, rest = name.partition(".")
    first = "cli" if rest == "__main__" else rest.split(".")[0]  # `python -m rolling` is its door
    is_room = first and (
        (ROOT / package / first).is_dir() or (ROOT / package / f"{first}.py").is_file()
    )
    return first if is_room else FRONT_DOOR


def arrows(package: str) -> set[tuple[str, str, str, str]]:
    """Return (room, imported room, module, imported name) of every import between rooms."""
    found = set()
    for module in modules(package):
        here = room(module)
        for name in imported(module):
            if name.split(".")[0] == package and room(name) != here:
                found.add((here, room(name), module, name))
    return found


@pytest.mark.parametrize("package", FLOORS)
def test_every_room_has_one_floor(package: str) -> None:
    placed = [name for floor in FLOORS[package] for name in floor]
    rooms = {room(module) for module in modules(package) if "." in module}
    assert len(placed) == len(set(placed))
    assert rooms <= set(placed), (
        f"give them a floor in {Path(__file__).name}: {sorted(rooms - set(placed))}"
    )


def test_the_house_is_small() -> None:
    """A stranger keeps 12 floors, 28 rooms and one meaning of a class name in mind."""
    assert max(map(len, FLOORS.values())) <= 12
    assert sum(map(len, FLOORS["rolling"])) <= 28
    names = [
        node.name
        for package in FLOORS
        for path in modules(package).values()
        for node in ast.walk(tree_of(path))
        if isinstance(node, ast.ClassDef)
    ]
    assert sorted({name for name in names if names.count(name) > 1}) == []


@pytest.mark.parametrize("package", FLOORS)
def test_rooms_import_lower_floors_only(package: str) -> None:
    floor = {name: height for height, names in enumerate(FLOORS[package]) for name in names}
    upwards = [
        f"{module} imports {name}"
        for here, there, module, name in sorted(arrows(package))
        if here != FRONT_DOOR and there != FRONT_DOOR and floor[there] >= floor[here]
    ]
    assert not upwards, "\n".join(upwards)


@pytest.mark.parametrize("package", FLOORS)
def test_rooms_take_nothing_from_the_front_door_but_version_and_place(package: str) -> None:
    taken = set()
    for _, there, module, name in arrows(package):
        if there == FRONT_DOOR and name == package:
            tree = tree_of(modules(package)[module])
            attributes = [node for node in ast.walk(tree) if isinstance(node, ast.Attribute)]
            taken |= {node.attr for node in attributes if ast.unparse(node.value) == package}
        elif there == FRONT_DOOR:
            taken.add(name.removeprefix(f"{package}."))
    assert taken <= {"__version__", "__file__"}


def test_methods_that_climb_only_call_the_function_of_a_higher_room() -> None:
    """Each is an import and a return; one that is gone leaves the list."""
    for module, methods in CLIMBING.items():
        tree = tree_of(modules("rolling")[module])
        bodies = {
            f"{node.name}.{name_of(part)}": part.body
            for node in tree.body
            if isinstance(node, ast.ClassDef)
            for part in node.body
            if isinstance(part, ast.FunctionDef)
        }
        for method in methods:
            kinds = [type(statement) for statement in bodies[method]]
            assert kinds == [ast.Expr, ast.ImportFrom, ast.Return], f"{module}: {method}"


@pytest.mark.parametrize("package", FLOORS)
def test_the_front_door_has_the_names_of_its_stub(package: str) -> None:
    """Editors and type checkers read the stub, and Python the table."""
    stub = ast.parse((ROOT / package / "__init__.pyi").read_text(encoding="utf-8"))
    names_of_stub = {
        alias.name: f"{node.module}.{alias.name}"
        for node in stub.body
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
    }
    door = importlib.import_module(package)
    homes = {name: f"{home}.{name}" for home, names in door._NAMES.items() for name in names}
    assert homes | door._SUBMODULES == names_of_stub
    assert door.__all__ == sorted(names_of_stub)
    assert all(getattr(door, name) is not None for name in names_of_stub)


@pytest.mark.parametrize("package", FLOORS)
def test_modules_do_not_import_each_other_in_a_circle(package: str) -> None:
    """Imports inside functions count too, since they hide a circle without breaking it.

    Imports for types alone do not count.
    """
    known = modules(package)
    graph: dict[str, set[str]] = {}
    for module in known:
        if module == package:
            continue
        names = imported(module, for_types=False)
        targets = {name if name in known else name.rpartition(".")[0] for name in names}
        graph[module] = {
            target for target in targets if target in known and target not in (package, module)
        }
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        pytest.fail(f"a circle: {' -> '.join(error.args[1])}")


def test_acoustics_knows_nothing_of_rolling() -> None:
    strangers = [
        (module, name)
        for module in modules("acoustics")
        for name in imported(module)
        if name.startswith("rolling")
    ]
    assert not strangers


@pytest.mark.parametrize(
    "code",
    [
        "import rolling",
        "import acoustics",
        "import rolling.cli\ntry: rolling.cli.main(['--help'])\nexcept SystemExit: pass",
    ],
    ids=["import rolling", "import acoustics", "rolling --help"],
)
def test_nothing_heavy_is_loaded_before_it_is_needed(code: str) -> None:
    code = f"import sys\n{code}\nprint('loaded:', *sorted(set(sys.modules) & {set(HEAVY)!r}))"
    printed = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=ROOT
    ).stdout
    assert printed.splitlines()[-1] == "loaded:"


def test_a_process_that_solves_loads_no_packages_of_pictures_motions_or_dask() -> None:
    """Every worker and every part of a sweep starts so: these packages took half of its time."""
    unused = {"matplotlib", "dask", "pandas", "xarray", "jinja2", "scipy.signal", "scipy.stats"}
    unused |= {"scipy.optimize", "scipy.integrate", "scipy.interpolate", "scipy.ndimage", "mosqito"}
    loaded = loaded_by("rolling.run.executor, rolling.run.worker as runs")
    assert not unused & loaded


def test_a_command_that_hands_out_tasks_loads_nothing_that_draws() -> None:
    """Its processes draw table, figures and page, and load what they need for that."""
    loaded = loaded_by("rolling.commands.run")
    assert not {"matplotlib", "pandas", "PIL", "jinja2", "h5py", "scipy.stats"} & loaded


def loaded_by(modules_to_import: str) -> set[str]:
    """Return the names of all modules in a process that imports some."""
    code = f"import sys, {modules_to_import}\nprint(*sys.modules)"
    printed = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=ROOT
    ).stdout
    return {*printed.split()}


def test_no_run_imports_the_slowest_packages_of_scipy() -> None:
    """They take half a second each; filters of long records and of a room need one when asked."""
    slow = ("scipy.signal", "scipy.stats")
    users = set()
    for package in FLOORS:
        for module in modules(package):
            if any(name.startswith(slow) for name in imported(module)):
                users.add(module)
    assert users == {"acoustics.resampling", "acoustics.room"}


def test_a_room_that_lists_its_files_lists_all_of_them() -> None:
    for name, path in modules("rolling").items():
        words = set(re.findall(r"\w+", ast.get_docstring(tree_of(path)) or ""))
        files = {file.stem for file in path.parent.glob("[a-z]*.py")}
        if path.stem == FRONT_DOOR and len(files & words) > len(files) / 2 and name != "rolling":
            assert files <= words, f"{name}: {sorted(files - words)} are lacking"


def test_a_file_name_stands_once() -> None:
    names = [
        name.rpartition(".")[2]
        for name in modules("rolling")
        if modules("rolling")[name].stem != FRONT_DOOR
    ]
    assert sorted(set(names)) == sorted(names)
