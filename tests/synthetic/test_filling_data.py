from collections import Counter

import numpy as np
import pytest

from corsmal.dataset import open_dataset
from corsmal.errors import ArgumentError, FileError, NotFoundError
from corsmal.filling import log_mel
from corsmal.filling.features import recording_features
from corsmal.synthetic.scene.containers import ANNOTATED_IDS
from corsmal.synthetic.scene.scene import BOX_FILLINGS, ROUND_FILLINGS, sound_events
from corsmal.synthetic.sound.recording import recording_sound
from corsmal.synthetic.training.filling import filling_scenes, write_filling_data
from corsmal.synthetic.writing.plan import demo_plan


def write(folder, **changes):
    return write_filling_data(folder, **{"seed": 3, "recordings_per_filling": 1, "containers": [9]} | changes)


@pytest.fixture(scope="module")
def root(tmp_path_factory):
    """Each of a tea box's five fillings once."""
    folder = tmp_path_factory.mktemp("filling") / "data"
    write(folder)
    return folder


def test_every_container_holds_every_filling_equally_often():
    scenes = filling_scenes(0, recordings_per_filling=2)
    counts = Counter((scene.container.container_id, scene.filling_type, scene.filling_level) for scene in scenes)
    assert len(counts) == 6 * len(ROUND_FILLINGS) + 3 * len(BOX_FILLINGS)
    assert set(counts.values()) == {2}
    assert {container for container, _, _ in counts} == set(ANNOTATED_IDS)
    types = Counter(scene.filling_type for scene in scenes)
    assert [types[number] for number in range(4)] == [18, 36, 36, 24]  # a sixth of the real set's 108, 216, 216, 144


def test_the_same_seed_gives_the_same_scenes_and_no_two_share_one():
    numbers = {
        seed: [scene.seed for scene in filling_scenes(seed, recordings_per_filling=1, containers=[1, 7])]
        for seed in (0, 1, 999)
    }
    assert numbers[0] == [scene.seed for scene in filling_scenes(0, recordings_per_filling=1, containers=[1, 7])]
    drawn = [number for found in numbers.values() for number in found]
    assert len(drawn) == len(set(drawn)) == 36


def test_no_scene_is_one_of_the_demo():
    [scene, *_] = filling_scenes(0, recordings_per_filling=1, containers=[1])
    lengths = {round(planned.scene().timing.end_s, 9) for planned in demo_plan(containers=[1])}
    assert round(scene.timing.end_s, 9) not in lengths


def test_a_dataset_with_features_and_no_sound_is_written(root):
    dataset = open_dataset(root)
    assert len(dataset) == 5
    pairs = {(row.filling_type, row.filling_level) for row in dataset.table.itertuples()}
    assert pairs == set(BOX_FILLINGS)
    assert set(dataset.table["container_id"]) == {9}
    scenes = filling_scenes(3, recordings_per_filling=1, containers=[9])
    for scene, recording in zip(scenes, dataset, strict=True):
        sound = recording_sound(sound_events(scene), rng=np.random.default_rng([scene.seed, 3]))
        features = recording_features(recording, folder=root / "features")
        assert recording.annotation.filling_type == scene.filling_type
        np.testing.assert_array_equal(features.values, log_mel(sound).astype(np.float16))


def test_a_stopped_call_is_finished_and_the_rest_is_kept(root):
    paths = sorted((root / "features").iterdir())
    before = {path.name: path.read_bytes() for path in paths}
    paths[2].unlink()
    times = {path: path.stat().st_mtime_ns for path in paths if path.exists()}
    seen = []
    assert write(root, progress=lambda done, total: seen.append((done, total))) == root / "features"
    assert seen == [(done, 5) for done in range(1, 6)]
    assert {path.name: path.read_bytes() for path in sorted((root / "features").iterdir())} == before
    assert all(path.stat().st_mtime_ns == time for path, time in times.items())


def test_another_seed_in_the_same_folder_is_refused(root):
    with pytest.raises(FileError, match="describes other recordings; choose another folder"):
        write(root, seed=4)


def test_folder_that_cannot_be_written_is_named(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(FileError, match=r"file.*cannot be written"):
        write(tmp_path / "file")


@pytest.mark.parametrize("changes", [{"seed": -1}, {"seed": 1000}, {"recordings_per_filling": 0}, {"containers": []}])
def test_numbers_out_of_range_are_refused(tmp_path, changes):
    with pytest.raises(ArgumentError, match=r"seed must lie in 0\.\.999"):
        write(tmp_path, **changes)


def test_unknown_container_is_named(tmp_path):
    with pytest.raises(NotFoundError, match="there is no demo container 16"):
        write(tmp_path, containers=[16])
