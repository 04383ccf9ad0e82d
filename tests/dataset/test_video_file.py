"""Videos as cameras and phones write them, made by changing the boxes of an MP4; OpenCV is the judge."""

import struct
from pathlib import Path

import av
import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from corsmal.dataset import Video
from corsmal.dataset.video import frame_times_s, video_size
from corsmal.dataset.video_file import file_turn
from corsmal.errors import FileError
from tests.tiny import write_video

COUNT, WIDTH, HEIGHT = 24, 64, 48
ONE = 1 << 16
_HOLD = {b"moov", b"trak", b"mdia", b"minf", b"stbl", b"edts"}


def numbered() -> list[NDArray[np.uint8]]:
    """Frames whose grey is ten times their number, each with one white corner."""
    images = [np.full((HEIGHT, WIDTH, 3), 10 * number, np.uint8) for number in range(COUNT)]
    for image in images:
        image[:16, :24] = 255
    return images


@pytest.fixture
def plain(tmp_path: Path) -> Path:
    return write_video(tmp_path / "plain.mp4", numbered(), bframes=0)


def boxes(data: bytes) -> list[list]:
    found, at = [], 0
    while at + 8 <= len(data):
        size, name = struct.unpack(">I4s", data[at : at + 8])
        inner = data[at + 8 : at + size]
        found.append([name, boxes(inner) if name in _HOLD else inner])
        at += size
    return found


def joined(tree: list[list]) -> bytes:
    parts = [(name, joined(inner) if isinstance(inner, list) else inner) for name, inner in tree]
    return b"".join(struct.pack(">I4s", len(inner) + 8, name) + inner for name, inner in parts)


def box(tree: list[list], *path: bytes) -> list:
    item = next(each for each in tree if each[0] == path[0])
    return item if len(path) == 1 else box(item[1], *path[1:])


def changed(source: Path, target: Path, path: tuple[bytes, ...], change) -> Path:
    tree = boxes(source.read_bytes())
    item = box(tree, *path)
    item[1] = change(item[1])
    target.write_bytes(joined(tree))
    return target


def with_matrix(source: Path, target: Path, matrix: tuple[int, int, int, int]) -> Path:
    a, b, c, d = matrix

    def change(head: bytes) -> bytes:
        return head[:40] + struct.pack(">9i", a * ONE, b * ONE, 0, c * ONE, d * ONE, 0, 0, 0, 1 << 30) + head[76:]

    return changed(source, target, (b"moov", b"trak", b"tkhd"), change)


def with_steps(source: Path, target: Path, runs: list[tuple[int, int]]) -> Path:
    """The time from frame to frame, as (how many, 1/15360 s)."""
    tree = boxes(source.read_bytes())
    track = box(tree, b"moov", b"trak")
    track[1] = [each for each in track[1] if each[0] != b"edts"]  # it would hide what is later than before
    target.write_bytes(joined(tree))
    content = struct.pack(">II", 0, len(runs)) + b"".join(struct.pack(">II", *run) for run in runs)
    return changed(target, target, (b"moov", b"trak", b"mdia", b"minf", b"stbl", b"stts"), lambda _: content)


def greys(video: Video, order=range) -> list[int]:
    return [round(float(video[index][24, 24, 0]) / 10) for index in order(len(video))]


def as_opencv(path: Path) -> NDArray[np.uint8]:
    return cv2.cvtColor(cv2.VideoCapture(str(path)).read()[1], cv2.COLOR_BGR2RGB)


@pytest.mark.parametrize("matrix", [(0, 1, -1, 0), (-1, 0, 0, -1), (0, -1, 1, 0), (1, 0, 0, 1)], ids=[90, 180, 270, 0])
def test_the_display_matrix_is_obeyed(plain: Path, tmp_path: Path, matrix: tuple[int, int, int, int]) -> None:
    path = with_matrix(plain, tmp_path / "turned.mp4", matrix)
    expected = as_opencv(path)
    with Video(path) as video:
        assert video.size == video_size(path) == expected.shape[1::-1]
        assert np.abs(np.subtract(video[0], expected, dtype=int)).mean() < 2
        assert greys(video) == list(range(COUNT))
        assert video[3].flags.c_contiguous


def test_a_mirrored_picture_is_mirrored(plain: Path, tmp_path: Path) -> None:
    path = with_matrix(plain, tmp_path / "mirrored.mp4", (-1, 0, 0, 1))
    with Video(path) as video, Video(plain) as straight:
        np.testing.assert_array_equal(video[0], straight[0][:, ::-1])


@pytest.mark.parametrize(
    "content", [b"", b"\0" * 40, struct.pack(">I4s", 4, b"moov"), struct.pack(">I4sQ", 1, b"moov", 3)]
)
def test_a_file_without_a_matrix_is_not_turned(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "a.mp4").write_bytes(content)
    assert file_turn(tmp_path / "a.mp4") == (False, False, False)


def test_a_cover_picture_is_no_video(plain: Path, tmp_path: Path) -> None:
    jpeg = cv2.imencode(".jpg", np.zeros((64, 64, 3), np.uint8))[1].tobytes()

    def pack(name: bytes, content: bytes) -> bytes:
        return struct.pack(">I4s", len(content) + 8, name) + content

    handler = pack(b"hdlr", struct.pack(">I4s4s4sIIB", 0, b"\0" * 4, b"mdir", b"appl", 0, 0, 0))
    cover = pack(b"ilst", pack(b"covr", pack(b"data", struct.pack(">II", 13, 0) + jpeg)))
    tree = boxes(plain.read_bytes())
    movie = box(tree, b"moov")
    others = [each for each in movie[1] if each[0] != b"udta"]
    movie[1] = [others[0], [b"udta", pack(b"meta", bytes(4) + handler + cover)], *others[1:]]
    path = tmp_path / "tagged.mp4"
    path.write_bytes(joined(tree))
    with av.open(str(path)) as container:
        assert container.streams.video[0].codec_context.name == "mjpeg"
    assert video_size(path) == (WIDTH, HEIGHT)
    with Video(path) as video:
        assert greys(video) == list(range(COUNT))
        assert greys(video, lambda count: reversed(range(count)))[::-1] == list(range(COUNT))


def test_of_two_videos_the_one_with_more_frames_is_read(tmp_path: Path) -> None:
    path = tmp_path / "two.mp4"
    with av.open(str(path), "w") as container:
        streams = [container.add_stream("libx264", rate=30) for _ in range(2)]
        for stream in streams:
            stream.width, stream.height, stream.pix_fmt = WIDTH, HEIGHT, "yuv420p"
        for stream, count in zip(streams, (1, COUNT), strict=True):
            for image in numbered()[:count]:
                container.mux(stream.encode(av.VideoFrame.from_ndarray(image, format="rgb24")))
            container.mux(stream.encode(None))
    with Video(path) as video:
        assert greys(video) == list(range(COUNT))


@pytest.mark.parametrize(
    "runs",
    [
        [(5, 512), (1, 0), (6, 512), (1, 0), (11, 512)],
        [(1, 0), (23, 512)],
        [(22, 512), (2, 0)],
        [(2, 512), (3, 0), (19, 512)],
        [(24, 0)],
    ],
    ids=["two pairs", "first", "last", "four at once", "all"],
)
def test_frames_with_one_time_stamp_all_count(tmp_path: Path, runs: list[tuple[int, int]]) -> None:
    source = write_video(tmp_path / "plain.mp4", numbered(), bframes=0, gop=6)
    path = with_steps(source, tmp_path / "equal.mp4", runs)
    with Video(path) as video:
        assert greys(video) == list(range(COUNT))
    for index in range(COUNT):
        with Video(path) as video:
            assert round(float(video[index][24, 24, 0]) / 10) == index
    assert len(frame_times_s(path)) == len(frame_times_s(path, exactly=False)) == COUNT


def test_times_are_those_of_the_file(plain: Path, tmp_path: Path) -> None:
    path = with_steps(plain, tmp_path / "varied.mp4", [(10, 512), (13, 1024), (1, 512)])
    expected = np.cumsum([0, *[1] * 10, *[2] * 13]) / 30
    np.testing.assert_allclose(frame_times_s(path), expected)
    np.testing.assert_allclose(frame_times_s(path, exactly=False), expected)
    with Video(path) as video:
        assert greys(video) == list(range(COUNT))


@pytest.mark.parametrize(
    ("ending", "codec"), [("avi", "mpeg4"), ("avi", "mjpeg"), ("mkv", "libx264"), ("mov", "libx264")]
)
def test_other_containers_are_read(tmp_path: Path, ending: str, codec: str) -> None:
    path = tmp_path / f"a.{ending}"
    with av.open(str(path), "w") as container:
        stream = container.add_stream(codec, rate=30)
        stream.width, stream.height = WIDTH, HEIGHT
        stream.pix_fmt = "yuvj420p" if codec == "mjpeg" else "yuv420p"
        for image in numbered():
            container.mux(stream.encode(av.VideoFrame.from_ndarray(image, format="rgb24")))
        container.mux(stream.encode(None))
    with Video(path) as video:
        assert np.abs(np.subtract(greys(video), range(COUNT))).max() <= 1
        np.testing.assert_allclose(np.diff(video.times_s), 1 / 30, atol=0.002)


def test_huge_pictures_are_refused_before_one_is_made(plain: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("corsmal.dataset.video_file.PIXELS_MAX", WIDTH * HEIGHT - 1)
    with pytest.raises(FileError, match="has pictures of 64x48 pixels, too large to be read"):
        Video(plain)


@pytest.mark.parametrize("tag", [b"\xe9t\xe9", b"\xf2\xff\xff"])
def test_tags_in_another_encoding_do_not_matter(plain: Path, tmp_path: Path, tag: bytes) -> None:
    content = plain.read_bytes()
    assert b"VideoHandler" in content
    path = tmp_path / "tags.mp4"
    path.write_bytes(content.replace(b"VideoHandler", tag.ljust(12, b"x")))
    with Video(path) as video:
        assert greys(video) == list(range(COUNT))


def test_a_video_in_an_unknown_form_is_named(plain: Path, tmp_path: Path) -> None:
    path = tmp_path / "unknown.mp4"
    path.write_bytes(plain.read_bytes().replace(b"avc1", b"zzzz"))
    with pytest.raises(FileError, match="holds no video"):
        Video(path)


@pytest.mark.parametrize("gop", [6, 12])
def test_an_avi_file_with_frames_out_of_order_is_counted_as_opencv_does(tmp_path: Path, gop: int) -> None:
    path = write_video(tmp_path / "a.avi", numbered(), bframes=2, gop=gop)
    reader = cv2.VideoCapture(str(path))
    expected = [round(float(reader.read()[1][24, 24, 0]) / 10) for _ in range(COUNT)]
    assert not reader.read()[0]
    with Video(path) as video:
        assert greys(video) == expected == list(range(COUNT))
        assert greys(video, lambda count: reversed(range(count))) == expected[::-1]
        assert [round(float(video[index][24, 24, 0]) / 10) for index in (23, 3, 17, 7, 6)] == [23, 3, 17, 7, 6]


def test_behind_damage_in_an_avi_file_with_frames_out_of_order_nothing_is_counted(tmp_path: Path) -> None:
    path = write_video(tmp_path / "a.avi", numbered(), bframes=2, gop=6)
    with av.open(str(path)) as container:
        places = [packet.pos for packet in container.demux(video=0) if packet.size]
    content = bytearray(path.read_bytes())
    content[places[8] + 8 : places[9]] = bytes(places[9] - places[8] - 8)
    path.write_bytes(content)
    with Video(path) as video:
        found = []
        for index in range(len(video)):
            try:
                found.append(round(float(video[index][24, 24, 0]) / 10))
            except FileError:
                found.append(None)
    assert found[:6] == list(range(6))
    assert all(number in (index, None) for index, number in enumerate(found))


def with_sound_first(path: Path) -> Path:
    with av.open(str(path), "w") as container:
        sound = container.add_stream("aac", rate=44_100)
        stream = container.add_stream("libx264", rate=30, options={"preset": "ultrafast"})
        stream.width, stream.height, stream.pix_fmt = WIDTH, HEIGHT, "yuv420p"
        for number, image in enumerate(numbered()):
            container.mux(stream.encode(av.VideoFrame.from_ndarray(image, format="rgb24")))
            silence = av.AudioFrame.from_ndarray(np.zeros((1, 1024), np.float32), format="fltp", layout="mono")
            silence.sample_rate, silence.pts = 44_100, 1024 * number
            container.mux(sound.encode(silence))
        container.mux(stream.encode(None))
    return path


def in_fragments(path: Path) -> Path:
    source = write_video(path.with_name("source.mp4"), numbered(), bframes=2)
    with (
        av.open(str(source)) as whole,
        av.open(str(path), "w", options={"movflags": "frag_keyframe+empty_moov"}) as parts,
    ):
        stream = parts.add_stream_from_template(whole.streams.video[0])
        for packet in whole.demux(video=0):
            if packet.size:
                packet.stream = stream
                parts.mux(packet)
    return path


FORMS = {
    "sound first": ("a.mp4", with_sound_first),
    "fragments": ("a.mp4", in_fragments),
    "WebM": ("a.webm", lambda path: write_video(path, numbered(), codec="libvpx-vp9", bframes=0)),
    "Matroska, variable rate": (
        "a.mkv",
        lambda path: write_video(path, numbered(), pts=[int(n**1.3) + n for n in range(COUNT)]),
    ),
    "MPEG": ("a.mpg", lambda path: write_video(path, numbered(), codec="mpeg2video", bframes=2)),
    "begins late": ("a.mov", lambda path: write_video(path, numbered(), pts=list(range(15, 15 + COUNT)))),
    "high rate": ("a.m4v", lambda path: write_video(path, numbered(), fps=120)),
}


@pytest.mark.parametrize("form", FORMS)
def test_frames_of_any_form_are_counted_as_opencv_counts_them(tmp_path: Path, form: str) -> None:
    name, write = FORMS[form]
    path = write(tmp_path / name)
    reader, expected = cv2.VideoCapture(str(path)), []
    while (read := reader.read())[0]:
        expected.append(round(float(read[1][24, 24, 0]) / 10))
    with Video(path) as video:
        assert greys(video) == expected
        assert len(expected) == COUNT
        assert greys(video, lambda count: reversed(range(count))) == expected[::-1]
        assert len(frame_times_s(path, exactly=False)) == COUNT


def test_a_frame_whose_colours_cannot_be_read_is_an_error(plain: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with Video(plain) as video:

        class Unreadable:
            def to_ndarray(self, **_options: str) -> None:
                raise av.error.OSError(95, "Operation not supported")

        monkeypatch.setattr(video, "_find", lambda _index: Unreadable())
        with pytest.raises(FileError, match="frame 3 has no picture; download the video again"):
            video[3]
