from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from pathlib import Path

import av
import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from corsmal.dataset import Video
from corsmal.dataset.video import FRAMES_KEPT, video_size
from corsmal.errors import ArgumentError, FileError, NotFoundError
from tests.tiny import write_video

Image = NDArray[np.uint8]
COUNT = 60


def _images(count: int = COUNT) -> list[Image]:
    """Moving noise with a square whose grey is the frame's number."""
    noise = np.random.default_rng(0).integers(0, 150, (48, 64, 3), dtype=np.uint8)
    images = [np.roll(noise, 3 * number, axis=1) for number in range(count)]
    for number, image in enumerate(images):
        image[8:24, 8:24] = 4 * number % 256
    return images


def _from_the_start(path: Path) -> list[Image]:
    with av.open(str(path)) as container:
        return [frame.to_ndarray(format="rgb24") for frame in container.decode(video=0)]


def _encode(path: Path, *, x264: str) -> Path:
    with av.open(str(path), "w") as container:
        stream = container.add_stream("libx264", rate=30, options={"x264-params": x264})
        stream.width, stream.height, stream.pix_fmt = 64, 48, "yuv420p"
        for number, image in enumerate(_images()):
            frame = av.VideoFrame.from_ndarray(image, format="rgb24")
            frame.pts = number
            container.mux(stream.encode(frame))
        container.mux(stream.encode(None))
    return path


def _shifted(path: Path, source: Path, *, frames: int) -> Path:
    """A copy whose time stamps begin elsewhere; the file format then hides the frames before time 0."""
    with av.open(str(source)) as whole, av.open(str(path), "w") as copy:
        stream = copy.add_stream_from_template(whole.streams.video[0])
        for packet in whole.demux(video=0):
            if packet.dts is not None and packet.pts is not None:
                packet.pts += frames * 512  # 1/15360 s, at 30 frames per second
                packet.dts += frames * 512
                packet.stream = stream
                copy.mux(packet)
    return path


VARIANTS: dict[str, Callable[[Path], Path]] = {
    "h264, gop 12, B-frames": lambda folder: write_video(folder / "v.mp4", _images(), gop=12, bframes=2),
    "h264, gop 250, B-frames": lambda folder: write_video(folder / "v.mp4", _images(), gop=250, bframes=3),
    "mpeg4, gop 12": lambda folder: write_video(folder / "v.mp4", _images(), codec="mpeg4", bframes=0),
    "mpeg4, B-frames": lambda folder: write_video(folder / "v.mp4", _images(), codec="mpeg4", bframes=2),
    "variable rate": lambda folder: write_video(
        folder / "v.mp4", _images(), pts=[number + number // 7 * 3 + (number > 20) * 40 for number in range(COUNT)]
    ),
    "open gop": lambda folder: _encode(
        folder / "v.mp4", x264="open-gop=1:keyint=12:min-keyint=12:scenecut=0:bframes=3"
    ),
    "intra refresh": lambda folder: _encode(folder / "v.mp4", x264="intra-refresh=1:keyint=20:bframes=2"),
    "starts late": lambda folder: _shifted(folder / "v.mp4", write_video(folder / "w.mp4", _images()), frames=25),
    "starts within a gop": lambda folder: _shifted(
        folder / "v.mp4", write_video(folder / "w.mp4", _images(), gop=250, bframes=3), frames=-7
    ),
    "one frame": lambda folder: write_video(folder / "v.mp4", _images(1)),
}


def _orders(count: int) -> dict[str, Iterable[int]]:
    shuffled = np.random.default_rng(1).permutation(np.repeat(np.arange(count), 2))
    return {"forward": range(count), "backward": range(count - 1, -1, -1), "random": shuffled.tolist()}


@pytest.mark.parametrize("variant", VARIANTS)
def test_frame_by_index_is_the_frame_that_reading_from_the_start_gives(tmp_path: Path, variant: str) -> None:
    path = VARIANTS[variant](tmp_path)
    expected = _from_the_start(path)
    assert expected
    for order in _orders(len(expected)).values():
        with Video(path) as video:
            assert video.frame_count == len(expected)
            for index in order:
                np.testing.assert_array_equal(video[index], expected[index])


def test_iteration_starts_at_the_first_frame_whatever_was_read_before(tmp_path: Path) -> None:
    path = write_video(tmp_path / "v.mp4", _images())
    with Video(path) as video:
        video[40]
        for frame, expected in zip(video, _from_the_start(path), strict=True):
            np.testing.assert_array_equal(frame, expected)


def test_frames_are_those_that_were_written(tmp_path: Path) -> None:
    with Video(write_video(tmp_path / "v.mp4", _images())) as video:
        for index in (0, 31, 59):
            assert abs(video[index][12:20, 12:20].mean() - 4 * index) < 6


def test_another_reader_agrees(tmp_path: Path) -> None:
    path = write_video(tmp_path / "v.mp4", _images())
    capture = cv2.VideoCapture(str(path))
    with Video(path) as video:
        for frame in video:
            is_read, expected = capture.read()
            assert is_read
            np.testing.assert_allclose(frame, expected[..., ::-1], atol=4)
        assert not capture.read()[0]
    capture.release()


def test_header(tmp_path: Path) -> None:
    path = write_video(tmp_path / "v.mp4", _images(), fps=25)
    with Video(path) as video:
        assert (video.fps, video.size, video.codec, len(video)) == (25.0, (64, 48), "h264", COUNT)
        assert (video[0].shape, video[0].dtype) == ((48, 64, 3), np.uint8)
    assert video_size(path) == (64, 48)


def test_one_video_is_shared_by_threads(tmp_path: Path) -> None:
    path = write_video(tmp_path / "v.mp4", _images())
    expected = _from_the_start(path)
    indices = np.random.default_rng(2).integers(COUNT, size=80).tolist()
    with Video(path) as video, ThreadPoolExecutor(4) as pool:
        for index, frame in zip(indices, pool.map(video.__getitem__, indices), strict=True):
            np.testing.assert_array_equal(frame, expected[index])


def test_frames_are_the_callers_own(tmp_path: Path) -> None:
    with Video(write_video(tmp_path / "v.mp4", _images())) as video:
        first = video[0]
        kept = first.copy()
        first[:] = 0
        np.testing.assert_array_equal(video[0], kept)


def test_a_step_back_decodes_nothing(tmp_path: Path) -> None:
    with Video(write_video(tmp_path / "v.mp4", _images(), gop=250)) as video:
        video[50]
        video._decoded = iter(())  # the decoder has nothing more to give
        for index in range(50, 50 - FRAMES_KEPT, -1):
            video[index]


@pytest.mark.parametrize("index", [COUNT, -COUNT - 1, 10**9])
def test_index_out_of_range_says_how_many_frames_there_are(tmp_path: Path, index: int) -> None:
    with (
        Video(write_video(tmp_path / "v.mp4", _images())) as video,
        pytest.raises(NotFoundError, match=r"v\.mp4 has 60 frames \(0 to 59\), there is no frame"),
    ):
        video[index]


def test_negative_index_counts_from_the_end_and_other_types_are_refused(tmp_path: Path) -> None:
    with Video(write_video(tmp_path / "v.mp4", _images())) as video:
        np.testing.assert_array_equal(video[-1], video[59])
        np.testing.assert_array_equal(video[np.int64(3)], video[3])
        with pytest.raises(ArgumentError, match="whole number"):
            video[1.0]  # type: ignore[index]


def test_closed_video_says_so(tmp_path: Path) -> None:
    video = Video(write_video(tmp_path / "v.mp4", _images()))
    video.close()
    video.close()
    with pytest.raises(ArgumentError, match="was closed"):
        video[0]


def _sound_only(path: Path) -> None:
    with av.open(str(path), "w") as container:
        stream = container.add_stream("aac", rate=44_100)
        frame = av.AudioFrame.from_ndarray(np.zeros((1, 1024), dtype=np.float32), format="fltp", layout="mono")
        frame.sample_rate = 44_100
        container.mux(stream.encode(frame))
        container.mux(stream.encode(None))


def test_file_that_is_no_video_is_named(tmp_path: Path) -> None:
    whole = write_video(tmp_path / "whole.mp4", _images()).read_bytes()
    playlist = b"#EXTM3U\n#EXT-X-TARGETDURATION:1\n#EXTINF:1,\nhttp://127.0.0.1:9/x.ts\n"
    for content in (b"", b"no video" * 99, whole[:3000], whole[-500:], playlist):
        (tmp_path / "v.mp4").write_bytes(content)
        with pytest.raises(FileError, match=r"v\.mp4: cannot be opened as an MP4 video"):
            Video(tmp_path / "v.mp4")
    _sound_only(tmp_path / "v.mp4")
    with pytest.raises(FileError, match=r"v\.mp4: holds no video"):
        Video(tmp_path / "v.mp4")
    with pytest.raises(FileError, match=r"absent\.mp4: there is no such video file"):
        Video(tmp_path / "absent.mp4")


def test_video_without_frames_is_an_error(tmp_path: Path) -> None:
    path = tmp_path / "v.mp4"
    with av.open(str(path), "w", options={"movflags": "empty_moov+frag_keyframe"}) as container:
        stream = container.add_stream("mpeg4", rate=30)
        stream.width, stream.height, stream.pix_fmt = 64, 48, "yuv420p"
        container.start_encoding()
    with pytest.raises(FileError, match=r"v\.mp4: .*(holds no frames|holds no video|cannot be opened)"):
        Video(path)


def _with_index_first(path: Path, images: list[Image]) -> Path:
    with av.open(str(path), "w", options={"movflags": "faststart"}) as container:
        stream = container.add_stream("libx264", rate=30, options={"g": "12", "bf": "2"})
        stream.width, stream.height, stream.pix_fmt = 64, 48, "yuv420p"
        for number, image in enumerate(images):
            frame = av.VideoFrame.from_ndarray(image, format="rgb24")
            frame.pts = number
            container.mux(stream.encode(frame))
        container.mux(stream.encode(None))
    return path


def test_frames_before_a_truncation_are_exact_and_those_behind_it_are_errors(tmp_path: Path) -> None:
    path = _with_index_first(tmp_path / "v.mp4", _images())
    expected = _from_the_start(path)
    content = path.read_bytes()
    path.write_bytes(content[: len(content) * 6 // 10])
    with Video(path) as video:
        assert 12 < video.frame_count < COUNT
        good = video.frame_count - 4  # frames near the cut may lack what they refer to
        for index in range(good):
            np.testing.assert_array_equal(video[index], expected[index])
        with pytest.raises(NotFoundError, match=f"has {video.frame_count} frames"):
            video[video.frame_count]
        for index in range(good, video.frame_count):
            with suppress(FileError):
                video[index]
        np.testing.assert_array_equal(video[3], expected[3])


def test_damage_in_the_middle_leaves_the_other_frames_exact(tmp_path: Path) -> None:
    path = _with_index_first(tmp_path / "v.mp4", _images())
    expected = _from_the_start(path)
    with av.open(str(path)) as container:
        packets = [packet for packet in container.demux(video=0) if packet.size]
        damaged = next(packet for packet in packets[20:] if not packet.is_keyframe)
        key = next(packet for packet in packets if packet.is_keyframe and packet.pts > damaged.pts)
        position, size, intact_from = damaged.pos, damaged.size, key.pts // 512
    content = bytearray(path.read_bytes())
    content[position : position + size] = b"\xff" * size
    path.write_bytes(content)
    with Video(path) as video:
        assert video.frame_count == COUNT
        for index in [*range(12), *range(intact_from, COUNT)]:
            np.testing.assert_array_equal(video[index], expected[index])
        with pytest.raises(FileError, match=r"v\.mp4: frame \d+ is damaged and cannot be decoded"):
            list(video)


def test_real_video_is_exact(real_dataset_root: Path) -> None:
    path = real_dataset_root / "view4" / "rgb" / "000618.mp4"
    expected = _from_the_start(path)
    with Video(path) as video:
        assert (video.frame_count, video.fps, video.size) == (77, 30.0, (1280, 720))
        for index in (0, 76, 75, 40, 41, 12, 11, 76):
            np.testing.assert_array_equal(video[index], expected[index])
