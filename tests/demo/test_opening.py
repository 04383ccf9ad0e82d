"""The ready-made demo is opened, not computed: copied into the store, under the keys that results have there."""

import json
import os
import shutil
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import pytest
from typer.testing import CliRunner

import corsmal.__main__ as cli
from corsmal.dataset import open_dataset
from corsmal.demo import opening
from corsmal.demo.opening import FOLDER, MARK, PACK, demo_folder, is_open, open_demo
from corsmal.demo.packing import IDS, PRESETS, packed_settings
from corsmal.errors import FileError
from corsmal.runs import delete_run, list_runs, load_run, make_run
from corsmal.runs.run import save_run
from corsmal.stages import estimates
from corsmal.store import Store
from corsmal.weights import file_sha256


@pytest.fixture
def opened(store):
    return open_dataset(open_demo(store=store))


@pytest.fixture
def no_estimates(monkeypatch):
    def computed(*_arguments):
        raise AssertionError("an estimate was computed that should have been in the store")

    monkeypatch.setattr(estimates, "_estimated", computed)


def test_it_is_a_dataset_with_nothing_missing(opened, store):
    assert opened.ids == IDS
    assert opened.problems == ()
    assert opened.root == demo_folder(store) == store.root.resolve() / FOLDER
    assert all(recording.missing == () and recording.is_synthetic for recording in opened)


def test_opening_takes_well_under_a_second_and_the_next_time_nothing(store):
    began_s = time.process_time()
    open_demo(store=store)
    assert time.process_time() - began_s < 1
    inodes = {path: path.stat().st_ino for path in store.root.rglob("*")}
    open_demo(store=store)
    assert {path: path.stat().st_ino for path in store.root.rglob("*")} == inodes


@pytest.mark.usefixtures("opened")
def test_all_files_have_the_time_of_the_pack(store):
    made_ns = json.loads((PACK / "recordings" / MARK).read_text(encoding="utf-8"))["made_ns"]
    files = [path for path in store.root.rglob("*") if path.is_file() and path.parts[-3] != "runs"]
    assert len(files) > 100
    assert {path.stat().st_mtime_ns for path in files} == {made_ns}


@pytest.mark.usefixtures("no_estimates")
@pytest.mark.parametrize("preset", PRESETS)
def test_kept_estimates_are_found_under_the_keys_of_this_store(opened, store, preset):
    predictors = packed_settings(opened, preset).open()
    run = load_run(preset, dataset=opened.root, store=store)
    rows = [estimates.load_estimate(recording, predictors, store=store) for recording in opened]
    assert [row["recording_id"] for row in rows] == list(IDS)
    assert rows == list(run.rows)


@pytest.mark.usefixtures("no_estimates")
@pytest.mark.parametrize("preset", PRESETS)
def test_its_runs_are_runs_like_all_others_and_can_be_updated(opened, store, preset):
    run = load_run(preset, dataset=opened.root, store=store)
    assert run.is_complete
    assert run.recordings == IDS
    assert run.preset == preset
    for file in (run.settings.filling, run.settings.mass):
        assert file.is_bundled
        assert run.digests[file.kind].endswith(file_sha256(file.path))
    again = make_run(preset, opened, run.settings, store=store)
    assert (again.rows, again.created, again.key) == (run.rows, run.created, run.key)
    assert make_run(None, opened, packed_settings(opened, preset), store=store).name == preset


def test_its_runs_are_listed_by_command(opened, store, monkeypatch):
    monkeypatch.setenv("CORSMAL_CACHE", str(store.root))
    result = CliRunner().invoke(cli.app, ["runs", "list", str(opened.root), "--json"], catch_exceptions=False)
    assert sorted(row["name"] for row in json.loads(result.stdout)) == sorted(PRESETS)


def test_no_packed_run_names_a_folder_of_the_machine_that_made_it():
    for run in list_runs(store=Store(PACK / "results")):
        settings = run.settings
        assert run.dataset == FOLDER
        paths = [settings.filling.path, settings.mass.path, settings.detector.weights]
        assert [path.parent.name for path in paths] == [""] * 3


def test_what_the_user_deletes_stays_deleted(opened, store):
    delete_run(load_run("tuned", dataset=opened.root, store=store), store=store)
    open_demo(store=store)
    assert [run.name for run in list_runs(store=store, dataset=opened.root)] == ["paper"]


def test_a_demo_of_another_version_is_replaced_and_own_runs_stay(opened, store):
    path = opened.root / "view1" / "rgb" / f"{IDS[0]}.mp4"
    content = path.read_bytes()
    path.write_bytes(b"an older video")
    (opened.root / "view1" / "rgb" / "000099.mp4").write_bytes(b"a recording that is no more")
    (opened.root / MARK).write_text('{"made_ns": 1}', encoding="utf-8")
    run = load_run("paper", dataset=opened.root, store=store)
    save_run(replace(run, name="mine", id=""), store=store)
    assert not is_open(store)
    open_demo(store=store)
    assert path.read_bytes() == content
    assert open_dataset(opened.root).ids == IDS
    names = [run.name for run in list_runs(store=store, dataset=opened.root)]
    assert sorted(names) == ["mine", "paper", "tuned"]


def test_one_that_was_copied_in_part_is_copied_again(opened, store):
    (opened.root / MARK).unlink()
    (opened.root / "audio" / f"{IDS[0]}.flac").unlink()
    open_demo(store=store)
    assert (opened.root / "audio" / f"{IDS[0]}.flac").is_file()


def test_several_who_open_it_at_once_find_it_whole(store):
    program = (
        "import sys; from pathlib import Path; from corsmal.demo.opening import open_demo\n"
        "from corsmal.store import Store; open_demo(store=Store(Path(sys.argv[1])))\n"
    )
    others = [subprocess.Popen([sys.executable, "-c", program, store.root], cwd=PACK.parents[2]) for _ in range(2)]

    def size(_number):
        return sum(path.stat().st_size for path in open_demo(store=store).rglob("*") if path.is_file())

    with ThreadPoolExecutor(6) as threads:
        sizes = set(threads.map(size, range(6)))
    assert [process.wait(60) for process in others] == [0, 0]
    assert sizes == {sum(path.stat().st_size for path in (PACK / "recordings").rglob("*") if path.is_file())}
    assert not [path for path in store.root.iterdir() if path.name.startswith(".")]


def test_a_store_that_cannot_be_written_is_one_sentence(blocked):
    with pytest.raises(FileError, match=r"cannot be written .*set CORSMAL_CACHE to a folder that can be written"):
        open_demo(store=blocked)


def test_a_broken_pack_is_named(store, tmp_path, monkeypatch):
    pack = tmp_path / "pack"
    shutil.copytree(PACK, pack)
    monkeypatch.setattr(opening, "PACK", pack)
    (pack / "recordings" / MARK).write_text("{}", encoding="utf-8")
    with pytest.raises(FileError, match=r"truth/pack\.json: is missing or broken; restore the library's files"):
        open_demo(store=store)
    os.unlink(pack / "recordings" / MARK)
    with pytest.raises(FileError, match="is missing or broken"):
        open_demo(store=store)
