import io
from threading import Thread

import cv2
import numpy as np
import pytest
import soundfile

from corsmal.dataset import open_dataset
from corsmal.detection import filter_detections
from corsmal.errors import NotFoundError
from corsmal.figures import draw_detections
from corsmal.parameters import SelectionParameters
from corsmal.stages.detections import load_detections
from corsmal.store import Store
from corsmal.ui.media import GAIN
from corsmal.ui.playback import PICTURE_WIDTH_PX, Playback, with_detections
from tests.tiny import FRAMES, SAMPLE_RATE_HZ, write_audio, write_tiny_dataset


def played(recording, *, names=("view1", "view2", "view3"), detections=None):
    videos = {name: recording.views[name].video() for name in names}
    return Playback(recording, videos, detections or {}, "both thirds")


@pytest.fixture(scope="module")
def recording(tiny_dataset_root):
    return open_dataset(tiny_dataset_root)["000000"]


def decoded(content):
    return cv2.cvtColor(cv2.imdecode(np.frombuffer(content, np.uint8), cv2.IMREAD_COLOR), cv2.COLOR_BGR2RGB)


def test_a_picture_is_the_frame_with_its_detections(recording, tmp_path):
    found = load_detections(recording, store=Store(tmp_path)).views
    plain = played(recording)
    frame = decoded(played(recording, detections=found).picture("view3", 2))
    image = plain.videos["view3"][2]
    drawn = draw_detections(image, found["view3"][2], filter_detections(found["view3"][2], centre_rule="both thirds"))
    assert frame.shape == (360, PICTURE_WIDTH_PX, 3)
    assert np.abs(frame.astype(int) - drawn).mean() < 3
    assert np.abs(decoded(plain.picture("view3", 2)).astype(int) - image).mean() < 3
    assert np.abs(image.astype(int) - drawn).max() > 50


def test_a_frame_that_was_not_inspected_is_shown_as_it_is(recording, tmp_path):
    found = load_detections(recording, store=Store(tmp_path)).views["view3"]
    image = np.zeros((360, 640, 3), np.uint8)
    assert with_detections(image, found, FRAMES + 5, centre_rule="none", selection=SelectionParameters()) is image
    assert with_detections(image, None, 0, centre_rule="none", selection=SelectionParameters()) is image


@pytest.mark.parametrize(("view", "frame"), [("view3", FRAMES), ("view3", -1), ("view1", 0), ("rgb", 0)])
def test_a_view_or_frame_that_is_not_there(recording, view, frame):
    with pytest.raises(NotFoundError):
        played(recording, names=("view3",)).picture(view, frame)


def test_frames_asked_for_out_of_order_and_at_once_are_those_asked_for(recording):
    playback, pictures = played(recording), {}
    expected = {frame: playback.picture("view1", frame) for frame in range(FRAMES)}
    threads = [
        Thread(target=lambda frame=frame: pictures.update({frame: playback.picture("view1", frame)}))
        for frame in sorted(range(FRAMES), key=lambda frame: frame * 7 % FRAMES)
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert pictures == expected


def test_sound_is_one_channel_or_the_mean_at_the_fixed_gain(tmp_path):
    root = write_tiny_dataset(tmp_path / "set", recordings=1, frames=2)
    write_audio(root / "audio" / "000000.wav", seconds=1)
    recording = open_dataset(root)["000000"]
    playback, samples = played(recording), recording.audio().samples
    for channel, expected in ((None, samples.mean(axis=0)), (7, samples[7])):
        heard, rate = soundfile.read(io.BytesIO(playback.sound(channel)))
        assert rate == SAMPLE_RATE_HZ
        np.testing.assert_allclose(heard, GAIN * expected, atol=1e-4)


def test_a_recording_without_sound_has_none_to_play(tiny_dataset_root):
    with pytest.raises(NotFoundError):
        played(open_dataset(tiny_dataset_root)["000001"], names=("view3",)).sound(None)
