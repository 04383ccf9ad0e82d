"""Who may import whom, and what the library must not do."""

import ast
import importlib
import importlib.util
import subprocess
import sys
from pathlib import Path
from types import ModuleType

import pytest

ROOT = Path(__file__).resolve().parents[1]
LIBRARY = ROOT / "corsmal"
FILES = sorted(LIBRARY.rglob("*.py"))
STUBS = sorted(LIBRARY.rglob("*.pyi"))
PAGES = [ROOT / "app.py", *sorted((ROOT / "pages").glob("*.py"))]
LINES_MAX = 260

FLOORS = (
    ("errors", "fields"),
    ("digests", "files", "notes", "state_dicts", "notebook", "installation"),
    ("weights", "checkpoints", "store", "geometry", "quantities", "parameters"),
    ("dataset",),
    ("detection",),
    ("selection", "shape", "mass", "filling", "by_hand"),
    ("estimation", "evaluation"),
    ("stages",),
    ("engines", "figures"),
    ("runs", "synthetic", "exchange"),
    ("demo",),
    ("ui", "commands"),
    ("app", "pages", "__main__"),
)
"""The rooms from the ground up: a room may import itself and what is on the floors below."""

FLOOR_OF = {room: floor for floor, rooms in enumerate(FLOORS) for room in rooms}


def room_of(path: Path) -> str:
    """The room that a file belongs to; empty for the package's own ``__init__``."""
    parts = path.relative_to(ROOT).with_suffix("").parts
    room = parts[1] if parts[0] == "corsmal" else parts[0]
    return "" if room == "__init__" else room


def imports_of(tree: ast.AST) -> set[str]:
    """Dotted names of all that is imported anywhere in a file, inside functions and for type checking too."""
    found = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, "imports are absolute"
            found |= {f"{node.module}.{alias.name}" for alias in node.names}
    return found


def name_of(path: Path) -> str:
    return str(path.relative_to(ROOT))


def dotted_calls(tree: ast.AST) -> list[tuple[str, ast.Call]]:
    """Every call with the dotted name of what is called."""
    return [(ast.unparse(node.func), node) for node in ast.walk(tree) if isinstance(node, ast.Call)]


@pytest.fixture(scope="module")
def trees():
    return {path: ast.parse(path.read_text(encoding="utf-8"), filename=str(path)) for path in (*FILES, *PAGES)}


@pytest.fixture(scope="module")
def calls(trees):
    return [(path, name, call) for path, tree in trees.items() for name, call in dotted_calls(tree)]


def forbidden(path: Path, imported: set[str]) -> set[str]:
    """Rooms among the imports of a file that it must not know."""
    here = room_of(path)
    rooms = {name.split(".")[1] for name in imported if name.startswith("corsmal.")} - {here}
    return {room for room in rooms if not here or FLOOR_OF[room] >= FLOOR_OF[here]}


def test_every_room_has_its_floor():
    assert {room_of(path) for path in (*FILES, *PAGES)} - {""} <= set(FLOOR_OF)


def test_forbidden_imports_are_seen():
    for text in ("from corsmal.mass import a", "def f():\n    import corsmal.mass.b as c", "from corsmal import mass"):
        imported = imports_of(ast.parse(text))
        assert forbidden(LIBRARY / "shape" / "a.py", imported) == {"mass"}
        assert forbidden(LIBRARY / "estimation.py", imported) == set()


def test_rooms_import_only_those_below(trees):
    found = {name_of(path): forbidden(path, imports_of(tree)) for path, tree in trees.items()}
    assert {path: rooms for path, rooms in found.items() if rooms} == {}


def test_lazy_names_come_from_stubs_that_name_their_own_room(trees):
    by_hand = [
        name_of(path)
        for path, tree in trees.items()
        if any(isinstance(node, ast.FunctionDef) and node.name == "__getattr__" for node in tree.body)
    ]
    assert by_hand == []
    for path in STUBS:
        for statement in ast.parse(path.read_text(encoding="utf-8")).body:
            assert isinstance(statement, ast.ImportFrom), (name_of(path), statement.lineno)
            assert (statement.level, statement.names[0].asname) == (1, statement.names[0].name), name_of(path)


def test_every_name_of_a_package_can_be_got(trees):
    """What ``__all__`` promises, and what any file imports from a package: a lazy name fails only when it is used."""
    packages = {".".join(path.parent.relative_to(ROOT).parts) for path in FILES if path.name == "__init__.py"}
    for name in sorted(packages):
        package = importlib.import_module(name)
        for public in getattr(package, "__all__", ()):
            assert not isinstance(getattr(package, public), ModuleType), f"{name}.{public}"
    imported = {name for tree in trees.values() for name in imports_of(tree) if name.rpartition(".")[0] in packages}
    assert len(imported) > 100
    for package, _, name in (dotted.rpartition(".") for dotted in sorted(imported)):
        is_name = hasattr(importlib.import_module(package), name)
        assert is_name or importlib.util.find_spec(f"{package}.{name}"), f"{package}.{name}"


def test_nothing_else_imports_the_inside_of_the_synthetic_world(trees):
    public = {f"corsmal.synthetic.{name}" for name in importlib.import_module("corsmal.synthetic").__all__}
    public.add("corsmal.synthetic")
    imported = {
        (name_of(path), name)
        for path, tree in trees.items()
        if room_of(path) != "synthetic"
        for name in imports_of(tree)
        if name.startswith("corsmal.synthetic")
    }
    assert len(imported) > 5
    assert {(path, name) for path, name in imported if name not in public} == set()


def test_only_what_is_shown_imports_streamlit(trees):
    paths = {
        path for path, tree in trees.items() if any(name.split(".")[0] == "streamlit" for name in imports_of(tree))
    }
    starts_the_app = LIBRARY / "commands" / "app.py"
    assert starts_the_app in paths
    assert {room_of(path) for path in paths - {starts_the_app}} == {"ui", "app", "pages"}


def test_nothing_prints_unpickles_or_runs_text(calls):
    unwanted = {"print", "pickle.load", "pickle.loads", "pickle.Unpickler", "joblib.load", "eval", "exec"}
    assert [(name_of(path), call.lineno, name) for path, name, call in calls if name in unwanted] == []


def test_inputs_are_not_checked_by_assert(trees):
    lines = [
        (name_of(path), node.lineno)
        for path, tree in trees.items()
        for node in ast.walk(tree)
        if isinstance(node, ast.Assert)
    ]
    assert lines == []


def test_weights_and_arrays_are_loaded_without_pickle(calls):
    for path, name, call in calls:
        given = {keyword.arg: ast.unparse(keyword.value) for keyword in call.keywords}
        if name == "torch.load":
            assert given.get("weights_only") == "True", (name_of(path), call.lineno)
        if name in ("np.load", "numpy.load"):
            assert given.get("allow_pickle", "False") == "False", (name_of(path), call.lineno)


def test_only_the_command_line_ends_the_program(calls):
    ends = {"sys.exit", "exit", "quit", "os._exit"}
    assert {room_of(path) for path, name, _ in calls if name in ends} <= {"__main__"}


def test_files_are_not_too_long():
    lengths = {name_of(path): len(path.read_text(encoding="utf-8").splitlines()) for path in (*FILES, *PAGES)}
    assert {name: lines for name, lines in lengths.items() if lines > LINES_MAX} == {}


HEAVY = ("torch", "cv2", "pandas", "streamlit", "numpy", "plotly", "numba", "av")


@pytest.mark.parametrize(
    ("statement", "absent"),
    [
        ("import corsmal", HEAVY),
        ("import corsmal.parameters, corsmal.errors, corsmal.weights", HEAVY),
        ("import corsmal.dataset, corsmal.detection, corsmal.filling, corsmal.mass, corsmal.evaluation", HEAVY),
        ("from corsmal.filling import LEVEL_NAMES", ("torch", "pandas", "streamlit", "numba")),
        ("from corsmal.mass import restore_mask", ("torch", "pandas", "streamlit", "numba")),
        ("from corsmal.dataset import open_dataset", ("torch", "cv2", "streamlit", "numba", "av")),
        ("from corsmal.detection import Detections", ("torch", "streamlit", "numba")),
        ("import corsmal.stages, corsmal.engines, corsmal.figures", ("torch", "streamlit")),
    ],
)
def test_importing_loads_only_what_is_needed(statement, absent):
    code = f"{statement}; import sys; print(*[name for name in {absent!r} if name in sys.modules])"
    result = subprocess.run(
        [sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, timeout=120, check=True
    )
    assert result.stdout.split() == []
