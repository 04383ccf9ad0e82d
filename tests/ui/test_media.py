import io
from dataclasses import replace

import av
import cv2
import numpy as np
import pytest
import soundfile

from corsmal.dataset import Audio, Video, open_dataset
from corsmal.errors import FileError, NotFoundError
from corsmal.ui import media
from corsmal.ui.media import GAIN, PREVIEW_WIDTH_PX, THUMBNAIL_WIDTH_PX, audio_wav, playable_video, thumbnail
from tests.tiny import write_video


@pytest.fixture(scope="module")
def recording(tiny_dataset_root):
    return open_dataset(tiny_dataset_root)["000000"]


@pytest.fixture
def old_video(recording, tmp_path):
    """A view whose video is MPEG-4 part 2, which browsers do not play, of an odd shape."""
    images = [np.full((90, 200, 3), (20 * number, 90, 40), dtype=np.uint8) for number in range(7)]
    path = write_video(tmp_path / "view1" / "rgb" / "000000.mp4", images, codec="mpeg4", bframes=0)
    return replace(recording.views["view1"], video_path=path)


def test_a_video_that_browsers_play_is_handed_out_as_it_is(recording, store):
    view = recording.views["view1"]
    assert playable_video(view, store=store) == view.video_path
    assert not store.root.exists()


def test_another_video_is_copied_as_h264_once(old_video, store, monkeypatch):
    path = playable_video(old_video, store=store)
    assert path.is_relative_to(store.root)
    with Video(path) as copy:
        assert (copy.codec, copy.frame_count) == ("h264", 7)
        assert copy.size == (PREVIEW_WIDTH_PX, 288)
        assert copy.fps == pytest.approx(30)
        red = [int(image[..., 0].mean()) for image in copy]
    np.testing.assert_allclose(red, 20 * np.arange(7), atol=12)
    with av.open(str(path)) as container:
        assert container.streams.video[0].codec_context.pix_fmt == "yuv420p"

    def refuse(*_args):
        raise AssertionError("the copy was there")

    monkeypatch.setattr(store, "writing", refuse)
    assert playable_video(old_video, store=store) == path


def test_a_copy_that_cannot_be_written_is_one_sentence(old_video, blocked):
    with pytest.raises(FileError, match="cannot be written"):
        playable_video(old_video, store=blocked)


def test_a_broken_video_leaves_no_copy(old_video, store):
    old_video.video_path.write_bytes(b"no video")
    with pytest.raises(FileError, match="cannot be opened"):
        playable_video(old_video, store=store)
    assert not list(store.root.rglob("*.mp4"))


def eight_channels():
    samples = np.zeros((8, 400), dtype=np.float32)
    samples[2] = np.linspace(-0.2, 0.2, 400)
    samples[5] = 0.9
    return Audio(samples, 44_100)


def played(content):
    samples, rate = soundfile.read(io.BytesIO(content), dtype="float64", always_2d=True)
    assert soundfile.info(io.BytesIO(content)).subtype == "PCM_16"
    assert rate == 44_100
    return samples


def test_a_channel_is_heard_with_the_fixed_gain():
    samples = played(audio_wav(eight_channels(), channel=2))
    assert samples.shape == (400, 1)
    np.testing.assert_allclose(samples[:, 0], GAIN * np.linspace(-0.2, 0.2, 400), atol=1 / 32_000)


def test_what_is_too_loud_is_clipped_and_does_not_wrap():
    assert played(audio_wav(eight_channels(), channel=5)).min() > 0.99


def test_all_channels_are_their_mean():
    expected = np.clip(GAIN * eight_channels().samples.mean(axis=0), -1, 1)
    np.testing.assert_allclose(played(audio_wav(eight_channels()))[:, 0], expected, atol=1 / 32_000)


def test_a_recordings_sound_can_be_heard(recording):
    audio = recording.audio()
    assert len(played(audio_wav(audio, channel=0))) == audio.samples.shape[1]


def test_channels_have_names():
    assert media.channel_name(None) == "mean of all"
    assert media.channel_name(0) == "microphone 1"


def decoded(content):
    return cv2.imdecode(np.frombuffer(content, np.uint8), cv2.IMREAD_COLOR_RGB)


def test_a_thumbnail_shows_the_middle_of_the_frontal_view(recording, store):
    image = decoded(thumbnail(recording, store=store))
    assert image.shape[1] == THUMBNAIL_WIDTH_PX
    with recording.views["view3"].video() as video:
        first = video[0]
    middle = first[:, 640 // 6 : 640 - 640 // 6]
    expected = cv2.resize(middle, image.shape[1::-1], interpolation=cv2.INTER_AREA)
    assert np.abs(image.astype(int) - expected).mean() < 4


def test_a_thumbnail_is_made_once(recording, store, monkeypatch):
    content = thumbnail(recording, store=store)
    [path] = store.root.rglob("*.jpg")
    assert path.read_bytes() == content

    def refuse(_self):
        raise AssertionError("the thumbnail was there")

    monkeypatch.setattr(type(recording.views["view3"]), "video", refuse)
    assert thumbnail(recording, store=store) == content


def test_another_view_stands_in_for_the_frontal_one(recording, store):
    views = {"view1": recording.views["view1"]}
    assert decoded(thumbnail(replace(recording, views=views), store=store)).shape[1] == THUMBNAIL_WIDTH_PX


def test_a_recording_without_video_has_no_thumbnail(recording, store):
    with pytest.raises(NotFoundError, match="recording 000000 has no video"):
        thumbnail(replace(recording, views={}), store=store)


def test_a_thumbnail_that_cannot_be_kept_is_shown_all_the_same(recording, blocked):
    assert decoded(thumbnail(recording, store=blocked)).shape[1] == THUMBNAIL_WIDTH_PX


def test_a_broken_video_has_no_thumbnail(old_video, recording, store):
    old_video.video_path.write_bytes(b"no video")
    with pytest.raises(FileError, match=r"000000\.mp4"):
        thumbnail(replace(recording, views={"view1": old_video}), store=store)
