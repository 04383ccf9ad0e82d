"""The demo's detector in processes of its own."""

import pytest

from corsmal.detection import SmallDetector
from corsmal.engines.inspector import ProcessInspector
from corsmal.errors import CorsmalError
from corsmal.parameters import METHOD_VIEWS
from corsmal.stages.detections import load_detections
from corsmal.stages.search import detect_recording
from corsmal.stages.settings import DetectorSettings
from corsmal.store import Store
from corsmal.weights import bundled_path

WEIGHTS = bundled_path("detector")


@pytest.fixture(scope="module")
def inspector():
    inspector = ProcessInspector(DetectorSettings("demo", WEIGHTS), workers=2)
    yield inspector
    inspector.close()


def test_processes_find_what_the_detector_finds_and_say_how_fast_they_are(inspector, dataset, store, tmp_path):
    recording, here = dataset["000002"], Store(tmp_path / "here")
    detector = SmallDetector(WEIGHTS)
    assert inspector.digest == detector.digest
    calls = []
    detect_recording(recording, inspector, store=store, every=4, progress=lambda *call: calls.append(call))
    detect_recording(recording, detector, store=here, every=4)
    found, expected = (load_detections(recording, store=one).views for one in (store, here))
    assert found.keys() == expected.keys() == set(METHOD_VIEWS)
    for name, view in expected.items():
        assert found[name].frames == view.frames
        assert found[name].source == view.source
        for frame in view:
            assert found[name][frame].labels.tolist() == view[frame].labels.tolist()
            assert found[name][frame].boxes == pytest.approx(view[frame].boxes, abs=0.1)
    assert calls[-1][0] == calls[-1][1]
    assert inspector.frame_s is not None
    assert 0 < inspector.frame_s < 10


def test_cancelled_work_keeps_what_was_begun(inspector, dataset, store):
    recording, done = dataset["000002"], []
    detect_recording(
        recording,
        inspector,
        store=store,
        progress=lambda count, _total: done.append(count),
        cancelled=lambda: bool(done and done[-1]),
    )
    found = load_detections(recording, store=store).views
    assert 1 <= sum(map(len, found.values())) <= 2 * 2 * inspector.piece_frames
    assert sum(map(len, found.values())) == done[-1]


def test_a_detector_that_cannot_be_opened_is_one_sentence(tmp_path):
    path = tmp_path / "none.safetensors"
    path.write_bytes(b"no weights")
    inspector = ProcessInspector(DetectorSettings("demo", path), workers=1)
    with pytest.raises(CorsmalError, match=str(path)):
        _ = inspector.digest
    inspector.close()
