"""Whatever stands in a file or an address from outside, its reader gives a record or one clear sentence."""

import json
import pickle
import warnings

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from corsmal.dataset import open_dataset
from corsmal.dataset.annotation_places import read_annotations
from corsmal.dataset.audio import CHANNELS, read_audio
from corsmal.dataset.calibration import read_camera
from corsmal.dataset.ids import ID_PATTERN
from corsmal.detection.coco import read_coco_results
from corsmal.errors import CorsmalError, NotFoundError
from corsmal.evaluation import read_estimates
from corsmal.ui.choice import Choice
from corsmal.ui.url import from_params, to_params
from tests.tiny import CALIBRATED_SIZE, tiny_cameras, write_audio, write_calibration, write_tiny_dataset

QUICK = settings(max_examples=60, suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow])
SIZE = (12, 16)

NUMBERS = st.one_of(
    st.integers(-5, 100), st.integers(), st.floats(), st.sampled_from([1e308, -1.0, 10**30, 2**63, float("nan")])
)
JSON = st.recursive(
    st.one_of(st.none(), st.booleans(), NUMBERS, st.text(max_size=8)),
    lambda inner: st.one_of(st.lists(inner, max_size=4), st.dictionaries(st.text(max_size=6), inner, max_size=3)),
    max_leaves=8,
)


def damages(length):
    """How a file of that length may be damaged: a few bytes changed, some cut out, some put in."""
    edit = st.tuples(st.integers(0, max(0, length - 1)), st.integers(0, 12), st.binary(max_size=12))
    return st.lists(edit, min_size=1, max_size=4)


def damaged(content, edits):
    for position, cut, inserted in edits:
        content = content[:position] + inserted + content[position + cut :]
    return content


def read(reader, path, content):
    """Write and read: the result, or None where the reader said in one sentence what is wrong."""
    path.write_bytes(content)
    try:
        return reader(path)
    except CorsmalError as error:
        said = str(error)
    assert "\n" not in said
    return None


@pytest.fixture(scope="module")
def calibration(tmp_path_factory):
    path = write_calibration(
        tmp_path_factory.mktemp("calibration") / "a.pickle", tiny_cameras(CALIBRATED_SIZE)["view1"]
    )
    return path.read_bytes()


@QUICK
@given(data=st.data())
def test_damaged_calibrations(calibration, tmp_path, data):
    content = damaged(calibration, data.draw(damages(len(calibration))))
    camera = read(read_camera, tmp_path / "a.pickle", content)
    assert camera is None or np.isfinite(camera.projection).all()


@QUICK
@given(value=JSON, protocol=st.integers(0, 5))
def test_pickles_that_are_no_calibrations(tmp_path, value, protocol):
    for content in (value, [value, value], [{"rgb": value}, {"rgb": {"rvec": value, "tvec": value}}]):
        read(read_camera, tmp_path / "a.pickle", pickle.dumps(content, protocol))


ENTRIES = st.fixed_dictionaries(
    {
        "image_id": st.one_of(st.integers(0, 3), JSON),
        "category_id": st.one_of(st.just(47), JSON),
        "score": st.one_of(st.just(0.9), JSON),
    },
    optional={
        "bbox": st.one_of(st.lists(NUMBERS, min_size=4, max_size=4), JSON),
        "segmentation": st.one_of(
            JSON,
            st.fixed_dictionaries({"size": st.one_of(st.just(list(SIZE)), JSON), "counts": st.one_of(st.text(), JSON)}),
            st.fixed_dictionaries({"size": st.just(list(SIZE)), "counts": st.lists(NUMBERS, max_size=6)}),
            st.lists(st.lists(NUMBERS, max_size=8), max_size=2),
        ),
    },
)


@QUICK
@given(entries=st.one_of(st.lists(st.one_of(ENTRIES, JSON), max_size=5), JSON), frames=st.sampled_from([None, 3]))
def test_coco_results(tmp_path, entries, frames):
    found = read(
        lambda path: read_coco_results(path, size=SIZE, frame_count=frames),
        tmp_path / "a.json",
        json.dumps(entries).encode("utf-8", "surrogatepass"),
    )
    for detections in {} if found is None else found.values():
        assert detections.masks.shape == (len(detections), *SIZE)
        assert np.isfinite(detections.boxes).all()


ROWS = st.dictionaries(
    st.sampled_from(["id", "ID ", "container id", "height", "filling type", "filling mass", "depth", "x"]), JSON
)


@QUICK
@given(rows=st.one_of(st.lists(st.one_of(ROWS, JSON), max_size=5), JSON), containers=JSON)
def test_annotations_in_json(tmp_path, rows, containers):
    content = json.dumps({"annotations": rows, "containers": containers})
    (tmp_path / "annotation.json").write_text(content, encoding="utf-8", errors="surrogatepass")
    check(read_annotations(tmp_path, ["annotation.json"]))


@QUICK
@given(text=st.text(st.one_of(st.sampled_from('id,\n"0123-\t;\0é'), st.characters()), max_size=80))
def test_annotations_in_csv(tmp_path, text):
    (tmp_path / "annotation.csv").write_text(
        "id,height,filling type\n" + text, encoding="utf-8", errors="surrogatepass"
    )
    check(read_annotations(tmp_path, ["annotation.csv"]))


def check(annotations):
    for name, annotation in annotations.by_id.items():
        assert ID_PATTERN.fullmatch(name)
        assert annotation.height_mm is None or 0 < annotation.height_mm < np.inf
        assert annotation.filling_type in {None, 0, 1, 2, 3}


@pytest.fixture(scope="module")
def sound(tmp_path_factory):
    return write_audio(tmp_path_factory.mktemp("sound") / "a.wav", seconds=0.02).read_bytes()


@QUICK
@given(data=st.data())
def test_damaged_sounds(sound, tmp_path, data):
    content = damaged(sound, data.draw(damages(64)))
    audio = read(read_audio, tmp_path / "a.wav", content)
    if audio is not None:
        assert audio.samples.shape[0] == CHANNELS
        assert 0 < audio.duration_s < 1000
        assert np.isfinite(audio.samples).all()


@QUICK
@given(text=st.text(st.one_of(st.sampled_from('0123,-.\n" e'), st.characters()), max_size=80))
@pytest.mark.parametrize("head", ["recording_id,height_mm\n", ""])
def test_estimates_tables(tmp_path, head, text):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # pandas warns of columns of mixed types
        read(read_estimates, tmp_path / "a.csv", (head + text).encode("utf-8", "surrogatepass"))


PARAMS = st.dictionaries(
    st.one_of(
        st.sampled_from(["recording", "pair", "frame", "crop", "ch", "preset", "L", "dmax", "z", "fit"]), st.text()
    ),
    st.one_of(st.text(), st.from_regex(r"[a-z]{0,8}[:-]?-?[0-9.e]{0,6}[:-]?-?[0-9.e_]{0,6}", fullmatch=True)),
    max_size=5,
)


@QUICK
@given(params=PARAMS)
def test_addresses(params):
    choice, problems = from_params(params)
    assert isinstance(choice, Choice)
    assert all("\n" not in problem for problem in problems)
    again, more = from_params(to_params(choice))
    assert (again, more) == (choice, ())


@pytest.fixture(scope="module")
def dataset(tmp_path_factory):
    return open_dataset(write_tiny_dataset(tmp_path_factory.mktemp("set"), recordings=1, frames=2))


@QUICK
@given(
    name=st.one_of(
        st.text(),
        st.lists(st.sampled_from(["..", "/", "000000", "view1", "\0", "%2e", "~", "."])).map("".join),
    )
)
def test_no_name_leaves_the_dataset(dataset, name):
    try:
        recording = dataset[name]
    except NotFoundError:
        return
    for view in recording.views.values():
        assert dataset.root in view.video_path.resolve().parents
