"""The package as others get it: a wheel, unpacked outside of the checkout."""

import os
import re
import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name
from typer.main import get_command

import corsmal
from corsmal.__main__ import app
from corsmal.installation import EXTRA_OF, app_script, checkout, default_cache, missing_extra

ROOT = Path(__file__).resolve().parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
EXTRAS = PROJECT["optional-dependencies"]

WITHOUT = """
import sys
for name in {absent!r}:
    sys.modules[name] = None
"""
"""Makes modules missing: importing one fails as if it were not installed."""


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    folder = tmp_path_factory.mktemp("wheel")
    build = [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", str(folder)]
    subprocess.run(build, cwd=ROOT, check=True, capture_output=True)
    [path] = folder.glob("*.whl")
    return path


@pytest.fixture(scope="module")
def installed(wheel, tmp_path_factory):
    """The folder of the unpacked wheel."""
    folder = tmp_path_factory.mktemp("installed")
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(folder)
    return folder


def run_installed(installed: Path, *arguments: str, **variables: str) -> subprocess.CompletedProcess[str]:
    """Python in another folder, with the unpacked wheel instead of the checkout."""
    named = {name: value for name, value in os.environ.items() if not name.startswith("CORSMAL_")}
    environment = {**named, "PYTHONPATH": str(installed), **variables}
    command = [sys.executable, *arguments]
    return subprocess.run(
        command, cwd=installed.parent, env=environment, capture_output=True, text=True, timeout=120, check=False
    )


def names_of(requirements: list[str]) -> dict[str, str]:
    """Specifiers by package; what an extra takes over from the package itself is left out."""
    parsed = [Requirement(line) for line in requirements]
    return {each.name: str(each.specifier) for each in parsed if each.name != PROJECT["name"]}


def test_the_requirements_are_those_of_the_package_and_its_extras():
    lines = (ROOT / "requirements.txt").read_text(encoding="utf-8").splitlines()
    listed = names_of([line for line in lines if line and not line.startswith("#")])
    of_package = names_of(PROJECT["dependencies"])
    for extra in ("app", "train", "dask", "dev"):
        of_package |= names_of(EXTRAS[extra])
    assert listed == of_package


def test_the_pinned_list_has_a_fitting_version_of_every_requirement():
    pins = [Requirement(line) for line in (ROOT / "requirements.lock").read_text(encoding="utf-8").splitlines()[1:]]
    pinned = {canonicalize_name(pin.name): str(pin.specifier).removeprefix("==") for pin in pins}
    lines = (ROOT / "requirements.txt").read_text(encoding="utf-8").splitlines()
    requirements = [Requirement(line) for line in lines if line and not line.startswith("#")]
    unmet = {str(each) for each in requirements if pinned.get(canonicalize_name(each.name), "0") not in each.specifier}
    assert unmet == set()
    assert len(pins) > 2 * len(requirements)


def test_the_citation_names_the_version():
    assert f"\nversion: {corsmal.__version__}\n" in (ROOT / "CITATION.cff").read_text(encoding="utf-8")


def test_the_short_commands_call_what_is_there():
    text = (ROOT / "Makefile").read_text(encoding="utf-8")
    targets = re.findall(r"^(\w+):", text, re.MULTILINE)
    assert targets == re.findall(r"\w+", re.findall(r"^\.PHONY: (.*)", text, re.MULTILINE)[0])
    extras = re.findall(r"\[([\w,]+)\]", text)
    assert {extra for names in extras for extra in names.split(",")} <= EXTRAS.keys()
    assert [path for path in re.findall(r"[\w.]+/\w+\.py", text) if not (ROOT / path).is_file()] == []


def test_the_container_installs_extras_and_copies_what_is_there():
    text = (ROOT / "Dockerfile").read_text(encoding="utf-8")
    [names] = re.findall(r"/src\[([\w,]+)\]", text)
    assert set(names.split(",")) <= EXTRAS.keys()
    torch = {name: spec for name, spec in names_of(PROJECT["dependencies"]).items() if name.startswith("torch")}
    for name, specifier in torch.items():
        [pin] = re.findall(rf'"{name}==([\d.]+)\.\*"', text)
        assert f"{pin}.0" in Requirement(f"{name}{specifier}").specifier
    [options] = re.findall(r'"corsmal", "app", (.*)\]', text)
    used = re.findall(r'"(--[\w-]+)"', options)
    assert set(used) <= {option for parameter in get_command(app).commands["app"].params for option in parameter.opts}


def test_every_module_that_may_be_missing_belongs_to_its_extra():
    packages = {"rerun": "rerun-sdk"}
    for module, extra in EXTRA_OF.items():
        assert packages.get(module, module) in names_of(EXTRAS[extra])
        assert module not in names_of(PROJECT["dependencies"])


def test_the_wheel_holds_what_is_not_python(installed):
    held = {str(path.relative_to(ROOT)) for path in (ROOT / "corsmal").rglob("*") if path.is_file()}
    held = {path for path in held if "__pycache__" not in path}
    assert len(held) > 400
    assert [path for path in sorted(held) if not (installed / path).is_file()] == []
    assert {"py.typed", "demo", "app"} <= {path.name for path in (installed / "corsmal").iterdir()}
    assert list(installed.glob("*.py")) == []  # app.py and pages would be modules of everybody's


def test_the_wheel_is_small(wheel):
    assert wheel.stat().st_size < 20e6


def test_the_version_is_that_of_the_package(installed):
    [metadata] = installed.glob("corsmal-*.dist-info/METADATA")
    assert f"\nVersion: {corsmal.__version__}\n" in metadata.read_text(encoding="utf-8")


def test_the_app_is_found_in_a_checkout_and_where_it_is_installed(installed):
    assert (checkout(), app_script(), default_cache()) == (ROOT, ROOT / "app.py", ROOT / "cache")
    code = "from corsmal.installation import *; print(checkout(), app_script(), default_cache(), sep='\\n')"
    found = run_installed(installed, "-c", code, XDG_CACHE_HOME="/somewhere").stdout.splitlines()
    assert found == ["None", str(installed / "corsmal" / "app" / "app.py"), "/somewhere/corsmal"]
    app = installed / "corsmal" / "app"
    for name in ("app.py", ".streamlit/config.toml", *(f"pages/{path.name}" for path in (ROOT / "pages").glob("*.py"))):
        assert (app / name).read_bytes() == (ROOT / name).read_bytes()


def test_the_installed_app_shows_the_demo(installed, tmp_path):
    """A run of its script by Streamlit's own test driver, in a process that has only the wheel."""
    code = """
from streamlit.testing.v1 import AppTest
from corsmal.installation import app_script
app = AppTest.from_file(str(app_script()), default_timeout=90).run()
print([title.value for title in app.title], list(app.exception), list(app.error))
"""
    result = run_installed(installed, "-c", code, XDG_CACHE_HOME=str(tmp_path), OMP_NUM_THREADS="1")
    assert result.stdout.splitlines()[-1:] == ["['Overview'] [] []"], result.stderr
    assert (tmp_path / "corsmal" / "demo-six").is_dir()


def test_the_library_needs_no_extra_to_fit_a_hull(installed, tmp_path):
    code = (
        WITHOUT.format(absent=list(EXTRA_OF))
        + f"""
from corsmal.dataset import open_dataset
from corsmal.demo.opening import open_demo
from corsmal.estimation import estimate
from corsmal.parameters import ShapeParameters
from corsmal.runs import list_runs
from corsmal.stages.detections import load_detections
from corsmal.store import Store
store = Store({str(tmp_path)!r})
recording = open_dataset(open_demo(store=store))["000000"]
detections = load_detections(recording, store=store)
found = estimate(recording, detections=detections.views, shape=ShapeParameters.paper())
print(found.status, len(found.fit.hull.radii_mm), len(list_runs(store=store)))
"""
    )
    result = run_installed(installed, "-c", code, OMP_NUM_THREADS="1")
    assert result.stdout.split() == ["fitted", "145", "2"], result.stderr


@pytest.mark.parametrize(
    ("arguments", "missing", "extra"),
    [(["app"], "streamlit", "app"), (["report", "ROOT", "NAME"], "plotly", "app")],
)
def test_a_command_says_which_extra_it_needs(installed, tmp_path, arguments, missing, extra):
    code = (
        WITHOUT.format(absent=list(EXTRA_OF)) + f"from corsmal.__main__ import main; sys.argv[1:] = {arguments}; main()"
    )
    result = run_installed(installed, "-c", code, CORSMAL_CACHE=str(tmp_path), COLUMNS="200")
    assert result.returncode == 1
    assert result.stderr == f"Error: this needs {missing}, which is not installed: pip install 'corsmal[{extra}]'\n"


def test_another_missing_module_is_not_blamed_on_an_extra():
    assert missing_extra(ModuleNotFoundError("", name="nothing.at.all")) is None
    assert missing_extra(ModuleNotFoundError("")) is None
    assert missing_extra(ModuleNotFoundError("", name="plotly.graph_objects")) is not None


def test_a_shell_can_complete_commands(installed):
    asked = {"_CORSMAL_COMPLETE": "complete_bash", "COMP_WORDS": "corsmal ev", "COMP_CWORD": "1"}
    code = "import sys; from corsmal.__main__ import main; sys.argv = ['corsmal']; main()"
    assert run_installed(installed, "-c", code, **asked).stdout.split() == ["evaluate"]
