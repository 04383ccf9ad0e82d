import contextlib
import json
import multiprocessing
import os
import pickle
import socket
import subprocess
import sys
import tempfile
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from corsmal.detection import Detections, ViewDetections
from corsmal.detection.parquet import read_parquet, write_parquet
from corsmal.errors import ArgumentError, FileError
from corsmal.notes import listening, repeat
from corsmal.store import BYTES_MAX, PROBLEMS_MAX, Store, digest

NOBODY = 65534
KEY = digest("a key")
SIZE = (6, 8)


def some_view():
    rng = np.random.default_rng(2)
    frames = {}
    for frame, n in {0: 0, 3: 2, 4: 0, 9: 1}.items():
        boxes = np.sort(rng.random((n, 2, 2)) * 6, axis=1).reshape(n, 4)
        labels = rng.integers(1, 91, n)
        frames[frame] = Detections(boxes, rng.random(n), labels, rng.random((n, *SIZE)) < 0.5)
    return ViewDetections(frames, size=SIZE, source="a test", problems=("one", "two é"))


def files(store):
    return sorted(path.name for path in store.root.rglob("*") if path.is_file())


def save_view(store, view=None):
    given = some_view() if view is None else view
    return store.write(store.file("detections", KEY, ".parquet"), partial(write_parquet, given))


def load_view(store):
    return store.read(store.file("detections", KEY, ".parquet"), read_parquet)


def put(content):
    """Damage that leaves a file with a part of what was in it, or with other bytes."""
    return lambda path: path.write_bytes(content(path.read_bytes()))


def instead(make):
    """Damage that puts something else in the place of the file."""

    def damage(path):
        path.unlink()
        make(path)

    return damage


def make_socket(path):
    with socket.socket(socket.AF_UNIX) as made:
        folder = os.getcwd()
        os.chdir(path.parent)  # a socket's path has 107 characters at most
        try:
            made.bind(path.name)
        finally:
            os.chdir(folder)


def make_huge(path):
    with path.open("wb") as file:
        file.truncate(BYTES_MAX + 1)


DAMAGES = {
    "empty": put(lambda _content: b""),
    "half": put(lambda content: content[: len(content) // 2]),
    "zeros": put(lambda content: bytes(len(content))),
    "other": put(lambda _content: b"[1]"),
    "random": put(lambda _content: np.random.default_rng(3).bytes(300)),
    "folder": instead(Path.mkdir),
    "pipe": instead(os.mkfifo),
    "socket": instead(make_socket),
    "link to nowhere": instead(lambda path: path.symlink_to("nowhere")),
    "link to itself": instead(lambda path: path.symlink_to(path)),
    "endless": instead(lambda path: path.symlink_to("/dev/zero")),
    "huge": instead(make_huge),
}


@contextlib.contextmanager
def as_another_user():
    """Be a user without rights; one who is none already stays what he is."""
    mine = os.geteuid()
    os.seteuid(NOBODY if mine == 0 else mine)
    try:
        yield
    finally:
        os.seteuid(mine)


KINDS = {
    ".parquet": (save_view, load_view),
    ".npz": (lambda store: store.save_arrays("hulls", KEY, a=np.arange(50)), lambda store: store.arrays("hulls", KEY)),
    ".json": (lambda store: store.save_json("fits", KEY, {"a": 1.5}), lambda store: store.json("fits", KEY)),
}


def run_apart(program, store, *args, check):
    """Run a program in a process of its own, which gets the store's folder and more."""
    repository = Path(__file__).resolve().parents[1]
    subprocess.run([sys.executable, "-c", program, str(store.root), *args], check=check, cwd=repository)


def the_file(store, suffix):
    [path] = store.root.rglob(f"*{suffix}")
    return path


@pytest.mark.parametrize("view", [some_view(), ViewDetections({}, size=SIZE, source="nothing")])
def test_detections_come_back_exactly_with_the_frames_that_have_none(store, view):
    assert save_view(store, view)
    again = load_view(store)
    assert again.frames == view.frames
    assert (again.size, again.source, again.problems) == (view.size, view.source, view.problems)
    for frame in view:
        assert again[frame].counts == view[frame].counts
        for name in ("boxes", "scores", "labels", "masks"):
            np.testing.assert_array_equal(getattr(again[frame], name), getattr(view[frame], name))
    assert store.file("detections", KEY, ".parquet").is_file()


def test_arrays_come_back_exactly(store):
    arrays = {
        "kind": np.array([1.5, np.nan, np.inf]),
        "file": np.zeros((0, 3), dtype=np.float32),
        "mask": np.eye(3, dtype=bool),
        "names": np.array(["a", "bé"]),
        "one": np.array(7, dtype=np.uint8),
    }
    assert store.save_arrays("hulls", KEY, **arrays)
    again = store.arrays("hulls", KEY)
    assert list(again) == list(arrays)
    for name, array in arrays.items():
        assert again[name].dtype == array.dtype
        np.testing.assert_array_equal(again[name], array)


def test_json_comes_back(store):
    value = {"a": [1, 2.5, None, "é"], "b": {"c": True}}
    assert store.save_json("fits", KEY, value)
    assert store.json("fits", KEY) == value


@pytest.mark.parametrize("suffix", KINDS)
def test_what_was_not_stored_is_none(store, blocked, suffix):
    for each in (store, blocked):
        assert KINDS[suffix][1](each) is None
        assert each.problems == ()


@pytest.mark.parametrize("suffix", KINDS)
@pytest.mark.parametrize("damage", DAMAGES)
def test_a_broken_file_is_set_aside_and_can_be_written_again(store, suffix, damage):
    save, load = KINDS[suffix]
    save(store)
    path = the_file(store, suffix)
    DAMAGES[damage](path)
    assert load(store) is None
    assert not os.path.lexists(path)
    assert os.path.lexists(path.with_name(f"{path.name}.broken"))
    assert store.has_remains(path)
    [problem] = store.problems
    assert problem.startswith(f"{path}: cannot be read (")
    assert "set aside" in problem
    assert load(Store(store.root)) is None
    assert save(store)
    assert load(store) is not None
    assert store.problems == (problem,)


def test_a_file_that_cannot_be_set_aside_is_said_with_what_to_do(store):
    store.save_json("fits", KEY, {})
    path = the_file(store, ".json")
    path.write_bytes(b"broken")
    path.with_name(f"{path.name}.broken").mkdir()
    assert store.json("fits", KEY) is None
    assert "it cannot be set aside either (Is a directory), delete it" in store.problems[-1]
    assert store.has_remains(path)


@pytest.mark.parametrize("suffix", KINDS)
def test_what_another_user_may_not_read_is_not_there_and_does_not_stop_him(suffix):
    with tempfile.TemporaryDirectory() as folder:  # pytest's own folders are closed to others
        os.chmod(folder, 0o777)
        store = Store(Path(folder) / "cache")
        save, load = KINDS[suffix]
        save(store)
        path = the_file(store, suffix)
        path.chmod(0)
        with as_another_user():
            assert load(store) is None
        [problem] = store.problems
        assert "cannot be read (Permission denied)" in problem
        (store.root / path.relative_to(store.root).parts[0]).chmod(0)
        with as_another_user():
            assert load(store) is None
            assert save(store) is False
        assert "Permission denied" in store.problems[-1]


def test_what_stores_say_is_heard_once_where_somebody_listens(store):
    path = store.file("fits", KEY, ".json")
    path.parent.mkdir(parents=True)
    path.write_bytes(b"broken")
    with listening() as outer:
        with listening() as said:
            store.json("fits", KEY)
        assert said == list(store.problems)
        assert outer == []
        repeat(said)
    assert outer == said
    repeat(said)
    assert outer == said


def plain(found):
    """What a store gave, in a form that can be compared."""
    if isinstance(found, ViewDetections):
        frames = {frame: (each.counts, each.boxes.tolist(), list(each.scores)) for frame, each in found.items()}
        return frames, found.size, found.source, found.problems
    return {name: np.asarray(value).tolist() for name, value in found.items()}


@pytest.mark.parametrize("suffix", KINDS)
def test_a_flipped_bit_gives_nothing_or_what_was_written(store, suffix):
    save, load = KINDS[suffix]
    save(store)
    path = the_file(store, suffix)
    content = path.read_bytes()
    written = plain(load(store))
    rng = np.random.default_rng(1)
    for position in rng.integers(0, len(content), 400):
        changed = bytearray(content)
        changed[position] ^= 1 << rng.integers(0, 8)
        path.write_bytes(changed)
        found = load(store)
        assert found is None or plain(found) == written


@pytest.mark.parametrize("suffix", KINDS)
def test_more_damage_gives_nothing_and_raises_nothing(store, suffix):
    save, load = KINDS[suffix]
    save(store)
    path = the_file(store, suffix)
    content = path.read_bytes()
    rng = np.random.default_rng(1)
    for _ in range(150):
        changed = bytearray(content)
        for position in rng.integers(0, len(content), rng.integers(2, 9)):
            changed[position] ^= rng.integers(1, 256)
        path.write_bytes(changed[: rng.integers(len(content) // 2, len(content) + 1)])
        load(store)


def test_files_without_checksums_are_computed_again(store):
    for suffix in (".json", ".npz"):
        path = store.file("old", KEY, suffix)
        path.parent.mkdir(parents=True, exist_ok=True)
    store.file("old", KEY, ".json").write_text('{"a": 1}', encoding="utf-8")
    np.savez(store.file("old", KEY, ".npz"), a=np.arange(3))
    assert store.json("old", KEY) is None
    assert store.arrays("old", KEY) is None
    assert len(store.leftovers()) == 2


def test_a_pickle_in_place_of_arrays_is_not_read(store):
    path = store.file("hulls", KEY, ".npz")
    path.parent.mkdir(parents=True)
    np.savez(path, a=np.array([{}], dtype=object))
    assert store.arrays("hulls", KEY) is None
    path.write_bytes(pickle.dumps([1]))
    assert store.arrays("hulls", KEY) is None


@pytest.mark.parametrize("suffix", KINDS)
def test_a_store_that_cannot_be_written_says_so_and_goes_on(blocked, suffix):
    assert KINDS[suffix][0](blocked) is False
    assert KINDS[suffix][0](blocked) is False
    [problem] = blocked.problems
    assert "cannot be written" in problem
    assert "CORSMAL_CACHE" in problem


def test_a_full_disk_leaves_the_older_file_and_nothing_else(store, monkeypatch):
    store.save_json("fits", KEY, {"a": 1})

    def full(part, *_args, **_options):
        part.touch()
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path, "write_bytes", full)
    assert store.save_json("fits", KEY, {"a": 2}) is False
    assert "No space left on device" in store.problems[-1]
    assert files(store) == [f"{KEY}.json"]
    assert store.json("fits", KEY) == {"a": 1}


@pytest.mark.parametrize("suffix", KINDS)
def test_a_disk_that_fills_up_while_writing_leaves_the_older_file_and_nothing_else(store, suffix):
    save, load = KINDS[suffix]
    save(store)
    program = (
        "import resource, signal, sys; from pathlib import Path; from tests.test_store import KINDS, Store\n"
        "signal.signal(signal.SIGXFSZ, signal.SIG_IGN); resource.setrlimit(resource.RLIMIT_FSIZE, (40, 40))\n"
        "store = Store(Path(sys.argv[1])); saved = KINDS[sys.argv[2]][0](store)\n"
        "sys.exit(saved or 'cannot be written' not in store.problems[-1])\n"
    )
    run_apart(program, store, suffix, check=True)
    assert files(store) == [f"{KEY}{suffix}"]
    assert load(store) is not None


def test_a_store_is_writable_or_says_why_not(store, blocked):
    store.check_writable()
    assert files(store) == ["writable"]
    with pytest.raises(FileError, match="cannot be written"):
        blocked.check_writable()


def test_what_a_killed_program_left_is_no_result_and_is_told(store):
    store.save_json("runs", KEY, {})
    path = store.file("runs", KEY, ".json")
    begun = path.with_name(f".{path.stem}.{'0' * 32}.json")
    begun.write_text("{", encoding="utf-8")
    assert store.keys("runs") == (KEY,)
    assert store.leftovers() == []  # another program may be writing it
    os.utime(begun, (0, 0))
    path.write_bytes(b"")
    assert store.json("runs", KEY) is None
    assert {left.name for left in store.leftovers()} == {begun.name, f"{path.name}.broken"}


class StoppedError(Exception):
    pass


def test_a_block_that_raises_leaves_the_older_file_and_nothing_else(store):
    path = store.file("videos", KEY, ".mp4")
    with store.writing(path) as part:
        part.write_bytes(b"whole")

    def write_half():
        with store.writing(path) as part:
            part.write_bytes(b"ha")
            raise StoppedError

    with pytest.raises(StoppedError):
        write_half()
    assert path.read_bytes() == b"whole"
    assert files(store) == [path.name]


def test_a_file_appears_only_when_it_is_whole(store):
    path = store.file("videos", KEY, ".mp4")
    with store.writing(path) as part:
        part.write_bytes(b"whole")
        assert part.parent == path.parent
        assert part.suffix == ".mp4"
        assert not path.exists()
    assert path.read_bytes() == b"whole"


def test_a_block_that_writes_nothing_or_cannot_write_is_an_error(store, blocked):
    with pytest.raises(FileError, match="cannot be written"), store.writing(store.file("videos", KEY, ".mp4")):
        pass
    with pytest.raises(FileError, match="cannot be written"), blocked.writing(blocked.file("videos", KEY, ".mp4")):
        pass


def test_a_killed_process_leaves_no_half_file(store):
    code = (
        "import os, signal, sys; from pathlib import Path; from corsmal.store import Store\n"
        "store = Store(Path(sys.argv[1])); path = store.file('videos', sys.argv[2], '.mp4')\n"
        "with store.writing(path) as part:\n"
        "    part.write_bytes(b'ha'); os.kill(os.getpid(), signal.SIGKILL)\n"
    )
    run_apart(code, store, KEY, check=False)
    path = store.file("videos", KEY, ".mp4")
    assert not path.exists()
    with store.writing(path) as part:
        part.write_bytes(b"whole")
    assert path.read_bytes() == b"whole"


@pytest.mark.parametrize("suffix", KINDS)
def test_eight_threads_may_write_and_read_one_result(store, suffix):
    save, load = KINDS[suffix]

    def work(_):
        return save(store) and load(store) is not None

    with ThreadPoolExecutor(8) as threads:
        assert all(threads.map(work, range(64)))
    assert files(store) == [f"{KEY}{suffix}"]
    assert store.problems == ()


def test_eight_processes_may_write_one_result(store):
    values = [np.full(20_000, value) for value in range(64)]
    with ProcessPoolExecutor(8, mp_context=multiprocessing.get_context("spawn")) as processes:
        saved = [processes.submit(store.save_arrays, "hulls", KEY, a=value) for value in values]
        while not all(future.done() for future in saved):
            found = store.arrays("hulls", KEY)
            assert found is None or len(np.unique(found["a"])) == 1
        assert all(future.result() for future in saved)
    assert store.problems == ()
    assert files(store) == [f"{KEY}.npz"]


@pytest.mark.parametrize(
    ("kind", "key", "suffix", "message"),
    [
        ("../up", KEY, ".npz", "kind"),
        ("", KEY, ".npz", "kind"),
        ("hulls", "../../up", ".npz", "key"),
        ("hulls", "000618", ".npz", "key"),
        ("hulls", KEY, "npz", "suffix"),
        ("hulls", KEY, "./npz", "suffix"),
    ],
)
def test_what_cannot_be_part_of_a_path_is_an_error(store, kind, key, suffix, message):
    with pytest.raises(ArgumentError, match=message):
        store.file(kind, key, suffix)


def test_values_that_would_need_a_pickle_or_are_no_json_are_errors(store):
    with pytest.raises(ArgumentError, match="a must be an array of numbers"):
        store.save_arrays("hulls", KEY, a=[{}])
    for value in ({"a": float("nan")}, {"a": np.zeros(2)}):
        with pytest.raises(ArgumentError, match="JSON"):
            store.save_json("fits", KEY, value)
    assert not store.root.exists()


def test_a_file_that_is_no_object_is_set_aside(store):
    store.save_json("fits", KEY, {})
    the_file(store, ".json").write_text(json.dumps([1]), encoding="utf-8")
    assert store.json("fits", KEY) is None


def test_problems_are_kept_once_the_last_one_last_and_not_without_end(blocked):
    keys = [digest(number) for number in range(PROBLEMS_MAX + 5)]
    for key in [*keys, keys[-3]]:
        blocked.save_json("fits", key, {})
    assert len(blocked.problems) == PROBLEMS_MAX
    assert keys[-3] in blocked.problems[-1]


def test_the_folder_is_the_named_one_or_the_repository_s(monkeypatch, tmp_path):
    monkeypatch.delenv("CORSMAL_CACHE", raising=False)
    assert Store().root == Path(__file__).resolve().parents[1] / "cache"
    monkeypatch.setenv("CORSMAL_CACHE", str(tmp_path))
    assert Store().root == tmp_path
    assert Store(tmp_path / "x").root == tmp_path / "x"


def test_a_store_travels_to_another_process(store):
    again = pickle.loads(pickle.dumps(store))
    assert again.root == store.root
