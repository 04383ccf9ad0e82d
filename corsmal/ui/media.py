"""Pictures, videos and sound in forms that a browser plays."""

import io
from pathlib import Path

import av
import numpy as np
import soundfile
from numpy.typing import NDArray

from corsmal.dataset import Audio, Recording, View
from corsmal.errors import NotFoundError
from corsmal.figures import jpeg
from corsmal.store import Store, digest, file_fingerprint

PREVIEW_WIDTH_PX = 640
THUMBNAIL_WIDTH_PX = 160
GAIN = 4.0
"""Recordings are quiet: one gain for all, so that louder still sounds louder."""


def playable_video(view: View, *, store: Store) -> Path:
    """A file with a view's video that browsers play: the view's own if it is H.264, else a smaller copy in the store.

    Raises:
        FileError: the video cannot be read, or the copy cannot be written.
    """
    with view.video() as video:
        if video.codec == "h264":
            return view.video_path
        path = store.file("previews", digest("preview", file_fingerprint(view.video_path)), ".mp4")
        if path.is_file():
            return path
        height = round(video.size[1] * PREVIEW_WIDTH_PX / video.size[0] / 2) * 2
        with store.writing(path, errors=(av.FFmpegError,)) as part, av.open(str(part), "w") as container:
            stream = container.add_stream("libx264", rate=max(1, round(video.fps)), options={"preset": "veryfast"})
            stream.width, stream.height, stream.pix_fmt = PREVIEW_WIDTH_PX, height, "yuv420p"
            for image in video:
                frame = av.VideoFrame.from_ndarray(image, format="rgb24")
                container.mux(stream.encode(frame.reformat(PREVIEW_WIDTH_PX, height, "yuv420p")))
            container.mux(stream.encode(None))
    return path


def mixed(audio: Audio, channel: int | None) -> NDArray[np.float32]:
    """One channel of a recording, from 0, or the mean of all: (S,) samples."""
    samples: NDArray[np.float32] = audio.samples.mean(axis=0) if channel is None else audio.samples[channel]
    return samples


def audio_wav(audio: Audio, *, channel: int | None = None, crop_s: tuple[float, float] | None = None) -> bytes:
    """One channel of a recording, or the mean of all, as a 16 bit WAV with a fixed gain.

    Args:
        audio: the recording's audio, (8, S).
        channel: from 0; None: the mean.
        crop_s: start and end, s; None: the whole.
    """
    start, end = (0, audio.samples.shape[1]) if crop_s is None else (round(s * audio.sample_rate_hz) for s in crop_s)
    buffer = io.BytesIO()
    amplified = np.clip(mixed(audio, channel)[start:end] * GAIN, -1, 1)
    soundfile.write(buffer, amplified, audio.sample_rate_hz, format="WAV", subtype="PCM_16")
    return buffer.getvalue()


def channel_name(channel: int | None) -> str:
    """A microphone as people count them, or what stands for all."""
    return "mean of all" if channel is None else f"microphone {channel + 1}"


def thumbnail(recording: Recording, *, store: Store) -> bytes:
    """The middle of the first frame of the frontal view, or of another if there is none, as a small JPEG.

    Raises:
        NotFoundError: the recording has no video.
        FileError: the video cannot be read.
    """
    name = next((name for name in ("view3", "view1", "view2", "view4") if name in recording.views), None)
    if name is None:
        raise NotFoundError(f"recording {recording.id} has no video")
    view = recording.views[name]
    path = store.file("thumbnails", digest("thumbnail", file_fingerprint(view.video_path)), ".jpg")
    kept = store.read(path, Path.read_bytes)
    if kept is not None:
        return kept
    with view.video() as video:
        image = video[0]
    width = image.shape[1]
    content = jpeg(image[:, width // 6 : width - width // 6], width=THUMBNAIL_WIDTH_PX)
    store.write(path, lambda part: part.write_bytes(content))
    return content
