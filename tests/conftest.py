"""Fixtures that more than one folder of tests uses, and how tests are shared out to several processes."""

import os
import tempfile
from collections.abc import Iterator
from pathlib import Path

import hypothesis
import pytest

from corsmal.store import Store
from tests.tiny import write_tiny_dataset

SHARED = Path(__file__).resolve().parents[1].parent / "shared"

hypothesis.settings.register_profile(
    "corsmal", deadline=None, suppress_health_check=[hypothesis.HealthCheck.too_slow]
)  # however slow the machine is
hypothesis.settings.load_profile("corsmal")


@pytest.hookimpl(tryfirst=True)
def pytest_cmdline_main(config: pytest.Config) -> None:
    """With ``-n`` the tests of a file stay in one process and files keep their order; every process has one thread.

    Fixtures of a module are made once, and the long tests of a browser do not come last. Threads that wait for each
    other would take the cores from the other processes, and sums over several threads differ in the last digits from
    those of workers, which have one. What draws the demo is compiled once, not in each process.
    """
    compiled = tempfile.TemporaryDirectory(prefix="corsmal-tests-")
    config.add_cleanup(compiled.cleanup)
    os.environ.setdefault("NUMBA_CACHE_DIR", compiled.name)
    if not config.getoption("benchmark_only", False):
        os.environ.setdefault("OMP_NUM_THREADS", "1")
    if getattr(config.option, "numprocesses", None):
        config.option.dist, config.option.loadscopereorder = "loadfile", False


@pytest.fixture(scope="session", autouse=True)
def nothing_left_in_the_checkout() -> Iterator[None]:
    """Commands write into the current folder by default; a test that runs one names another place."""
    top = Path(__file__).resolve().parents[1]
    before = set(top.iterdir())
    yield
    left = [path.name for path in set(top.iterdir()) - before if path.is_file() and not path.name.startswith(".")]
    assert not left, f"tests have left files in the checkout: {', '.join(sorted(left))}"


@pytest.fixture(scope="session")
def shared_root() -> Path:
    """The folder of real data beside the repository; tests that use it skip where it is absent."""
    if not SHARED.is_dir():
        pytest.skip(f"needs the real data in {SHARED.parent.name}/shared beside the repository")
    return SHARED


@pytest.fixture(scope="session")
def real_dataset_root(shared_root: Path) -> Path:
    """Recording 000618 in the dataset's own layout, with the full training annotation."""
    return shared_root / "ccm" / "train"


@pytest.fixture(scope="session")
def tiny_dataset_root(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Three generated recordings; read only, a test that changes files writes its own."""
    return write_tiny_dataset(tmp_path_factory.mktemp("tiny"))


@pytest.fixture
def store(tmp_path: Path) -> Store:
    """An empty store of the test's own."""
    return Store(tmp_path / "cache")


@pytest.fixture
def blocked(tmp_path: Path) -> Store:
    """A store that cannot be written: its folder would lie beneath a file."""
    (tmp_path / "file").write_bytes(b"")
    return Store(tmp_path / "file" / "cache")
