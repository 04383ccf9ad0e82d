"""The Filling page: what the network says follows the crop; sound or weights that lack or are broken are a sentence."""

import base64
import io
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pandas as pd
import pytest
import soundfile
import torch

from corsmal.dataset import open_dataset
from corsmal.filling import (
    FillingConfig,
    FillingModel,
    FillingPrediction,
    FillingPredictor,
    FusedPrediction,
    FusedPredictor,
    released,
    save_filling,
)
from corsmal.filling.config import PooledConfig, RecurrentConfig
from corsmal.filling.features import recording_features
from corsmal.filling.fused import FusedConfig, FusedModel, save_fused
from corsmal.ui import media
from corsmal.ui.filling import sound, timeline
from corsmal.ui.filling.downloads import windows_table
from corsmal.ui.media import GAIN
from corsmal.ui.opened import OpenedRecording
from tests.app.driver import Visitor
from tests.released import write_released
from tests.tiny import SAMPLE_RATE_HZ, write_audio

NAME = "000000"
HEADS = ("type", "level")
ROW_S = 1024 / SAMPLE_RATE_HZ
SMALL: dict[str, int] = {"heads": 2, "blocks": 1, "hidden": 16, "head_hidden": 8}


def write_weights(path: Path, **changes: int) -> Path:
    """A network that has learnt nothing, but whose answers differ from crop to crop."""
    torch.manual_seed(2)
    save_filling(path, [FillingModel(FillingConfig(**(SMALL | changes))).eval()])
    return path


@pytest.fixture(scope="module")
def weights(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_weights(tmp_path_factory.mktemp("filling") / "filling.safetensors")


@pytest.fixture(autouse=True)
def page(weights: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CORSMAL_FILLING_WEIGHTS", str(weights))


@pytest.fixture
def wav(root: Path) -> Path:
    return root / "audio" / f"{NAME}.wav"


@pytest.fixture
def noisy(root: Path, wav: Path) -> Path:
    """A dataset with three seconds of noise."""
    write_audio(wav, seconds=3)
    return root


@pytest.fixture
def visitor(noisy: Path) -> Visitor:
    return Visitor(noisy).open("filling")


def by_hand(root: Path, weights: Path, rows: tuple[int, int] | None = None) -> FillingPrediction:
    """What a program without the app would be told."""
    features = recording_features(open_dataset(root)[NAME])
    return FillingPredictor(weights).predict(features.values, crop=rows)


def assert_answers(visitor: Visitor, expected: FillingPrediction) -> None:
    assert visitor.crashes == visitor.errors == []
    for head in HEADS:
        bars = visitor.plots[f"answer_{head}"]["figure"]["data"][0]
        np.testing.assert_allclose(bars["x"], 100 * getattr(expected, f"{head}_probabilities"), rtol=1e-4)


def span_of(visitor: Visitor) -> tuple[float, ...]:
    return tuple(visitor.plots[timeline.TIMELINE]["span"]["values"])


def traces(visitor: Visitor, axis: str) -> list[dict[str, Any]]:
    return [trace for trace in visitor.plots[timeline.TIMELINE]["figure"]["data"] if trace.get("yaxis", "y") == axis]


def test_page_opens_with_the_answer_to_the_whole_recording(visitor: Visitor, root: Path, weights: Path) -> None:
    assert_answers(visitor, by_hand(root, weights))
    assert span_of(visitor) == (0, 3)
    assert visitor.count("audio") == 1
    assert visitor.warnings == []
    assert visitor.address == {"recording": NAME}


def test_answer_stands_beside_the_truth(visitor: Visitor, root: Path, weights: Path) -> None:
    prediction = by_hand(root, weights)
    notes = {metric.label: metric.delta for metric in visitor.test.metric}
    assert notes["Filling type"] == ("✓" if prediction.filling_type == 0 else "✗") + " annotated: none"
    assert notes["Filling level"] == ("✓" if prediction.filling_level == 0 else "✗") + " annotated: empty"
    for head, name in (("type", "none"), ("level", "empty")):
        assert f"<b>◆ {name}</b>" in visitor.plots[f"answer_{head}"]["figure"]["layout"]["yaxis"]["ticktext"]


def test_dragging_a_handle_asks_again_and_only_letting_go_writes_the_address(
    visitor: Visitor, root: Path, weights: Path
) -> None:
    visitor.report(timeline.TIMELINE, values={"crop_from": 1.0}, settled=False)
    total = 1 + 3 * SAMPLE_RATE_HZ // 1024
    assert_answers(visitor, by_hand(root, weights, (round(1 / ROW_S), total)))
    assert "crop" not in visitor.address
    visitor.report(timeline.TIMELINE, values={"crop_to": 2.0}, settled=True)
    assert_answers(visitor, by_hand(root, weights, (round(1 / ROW_S), round(2 / ROW_S) + 1)))
    assert visitor.address["crop"] == "1.00-2.00"
    assert span_of(visitor) == (1, 2)
    (attention,) = traces(visitor, "y3")
    assert (attention["x"][0], attention["x"][-1]) == pytest.approx((1, 2), abs=ROW_S / 2)


def test_bars_of_a_crop_are_marked_with_the_whole_recording(visitor: Visitor, root: Path, weights: Path) -> None:
    visitor.report(timeline.TIMELINE, values={"crop_from": 1.0}, settled=True)
    marks = visitor.plots["answer_type"]["figure"]["data"][-1]
    probabilities = by_hand(root, weights).type_probabilities
    assert probabilities is not None
    np.testing.assert_allclose(marks["x"], 100 * probabilities, rtol=1e-4)


def test_whole_recording_is_a_button_away(visitor: Visitor, root: Path, weights: Path) -> None:
    visitor.report(timeline.TIMELINE, values={"crop_from": 1.0, "crop_to": 1.5}, settled=True)
    visitor.press("Whole recording")
    assert_answers(visitor, by_hand(root, weights))
    assert visitor.address == {"recording": NAME}


@pytest.mark.parametrize(
    ("dragged", "crop"),
    [
        ({"crop_from": -9.0, "crop_to": 2.0}, (0, 2)),
        ({"crop_from": 1e12}, (2.75, 3)),
        ({"crop_to": -3.0}, (0, 0.25)),
        ({"crop_from": 2.0, "crop_to": 1.0}, (0.75, 1)),
        ({"colour": 1.0}, (0, 3)),
    ],
)
def test_ends_that_no_browser_sends_are_brought_within_the_recording(
    visitor: Visitor, dragged: dict[str, float], crop: tuple[float, float]
) -> None:
    visitor.report(timeline.TIMELINE, values=dragged, settled=True)
    assert visitor.crashes == visitor.errors == []
    assert span_of(visitor) == pytest.approx(crop)


def test_address_holds_the_crop_and_the_microphone(noisy: Path, weights: Path) -> None:
    other = Visitor(noisy, recording=NAME, crop="0.50-1.50", ch="3").open("filling")
    assert_answers(other, by_hand(noisy, weights, (round(0.5 / ROW_S), round(1.5 / ROW_S) + 1)))
    assert other.address == {"recording": NAME, "crop": "0.50-1.50", "ch": "3"}
    assert "microphone 3" in str(other.plots[timeline.TIMELINE]["figure"]["layout"]["annotations"])


def test_crop_after_the_end_is_left_out_and_reported(noisy: Path) -> None:
    other = Visitor(noisy, recording=NAME, crop="100-200").open("filling")
    assert other.warnings == ["The crop from 100.00 to 200.00 s was ignored: the recording ends at 3.00 s."]
    assert span_of(other) == (0, 3)
    assert other.address == {"recording": NAME}


def test_microphone_is_drawn_and_leaves_the_answer(visitor: Visitor, root: Path, weights: Path) -> None:
    visitor.choose("channel_control", 7)
    assert visitor.address["ch"] == "8"
    assert max(traces(visitor, "y")[1]["y"]) == pytest.approx(open_dataset(root)[NAME].audio().samples[7].max())
    assert_answers(visitor, by_hand(root, weights))


def test_time_line_has_the_crop_and_the_sound_of_the_channel(visitor: Visitor) -> None:
    assert visitor.plots[timeline.TIMELINE]["frame_on_x"] == pytest.approx(1 / 30)
    assert (visitor.time_line["crop"], visitor.time_line["fps"]) == (None, 30)
    assert visitor.time_line["sound"].endswith("/sound/0.wav")
    visitor.report(timeline.TIMELINE, values={"crop_from": 0.1}, settled=True)
    visitor.choose("channel_control", 7)
    visitor.go_to(3)
    assert visitor.time_line["crop"] == pytest.approx([3, 5])  # there are six frames, and three seconds of sound
    assert visitor.time_line["sound"].endswith("/sound/8.wav")
    assert visitor.address["frame"] == "3"


def test_frame_after_the_end_is_left_out_and_reported(noisy: Path) -> None:
    other = Visitor(noisy, recording=NAME, frame="6").open("filling")
    assert other.crashes == []
    (warning,) = other.warnings
    assert "allowed range 0–5" in warning
    assert other.address == {"recording": NAME}


def test_windows_slide_across_the_recording(visitor: Visitor, root: Path, weights: Path) -> None:
    windows = FillingPredictor(weights).predict_windows(
        recording_features(open_dataset(root)[NAME]).values, window=43, hop=sound.HOP_MIN, steps_s=ROW_S
    )
    for axis, head in (("y4", "type"), ("y5", "level")):
        areas = traces(visitor, axis)
        shares = np.array([getattr(window, f"{head}_probabilities") for window in windows])
        np.testing.assert_allclose(np.column_stack([area["y"] for area in areas]), 100 * shares, rtol=1e-4)
        np.testing.assert_allclose(areas[0]["x"], [(start + 21) * ROW_S for start in range(0, 87, 4)], rtol=1e-4)
    table = windows_table(windows)
    assert list(table.columns[:4]) == ["start_s", "end_s", "type", "level"]
    read = pd.read_csv(io.StringIO(table.to_csv(index=False)), keep_default_na=False)
    assert read["probability_water"][5] == pytest.approx(windows[5].probabilities["water"])
    difference = windows[5].probabilities["full"] / windows[5].probabilities["half"]
    assert read["logit_full"][5] - read["logit_half"][5] == pytest.approx(np.log(difference))
    assert set(read["type"]) <= {"none", "pasta", "rice", "water"}


def test_what_is_heard_is_the_crop_at_the_fixed_gain(noisy: Path) -> None:
    recording = open_dataset(noisy)[NAME]
    samples, rate = soundfile.read(io.BytesIO(sound.wav(OpenedRecording(recording), 2, (0.5, 1.5))))
    expected = GAIN * recording.audio().samples[2, rate // 2 : rate // 2 + rate]
    np.testing.assert_allclose(samples, expected, atol=1e-4)


def test_recording_without_sound_says_so(tiny_dataset_root: Path) -> None:
    visitor = Visitor(tiny_dataset_root, recording="000001").open("filling")
    assert visitor.crashes == []
    assert visitor.errors == []
    assert "recording 000001 has no sound: audio/000001.wav is missing" in visitor.sentences


def truncated(path: Path) -> None:
    path.write_bytes(path.read_bytes()[:20])


def not_finite(path: Path) -> None:
    samples = np.zeros((4000, 8), dtype=np.float32)
    samples[7, 3] = np.nan
    soundfile.write(path, samples, SAMPLE_RATE_HZ, subtype="FLOAT")


def empty(path: Path) -> None:
    soundfile.write(path, np.zeros((0, 8)), SAMPLE_RATE_HZ)


@pytest.mark.parametrize(
    ("damage", "words"),
    [
        (truncated, "cannot be read as sound"),
        (not_finite, "not finite"),
        (empty, "holds no sound"),
        (lambda path: write_audio(path, channels=2), "has 2 channels"),
        (lambda path: path.write_bytes(b""), "cannot be read as sound"),
    ],
)
def test_broken_sound_is_one_sentence_that_names_the_file(
    visitor: Visitor, wav: Path, damage: Callable[[Path], object], words: str
) -> None:
    damage(wav)
    visitor.test.run()
    assert visitor.crashes == []
    assert len(visitor.errors) == 1
    assert str(wav) in visitor.errors[0]
    assert words in visitor.errors[0]


@pytest.mark.parametrize(
    ("samples", "rate"), [(4000, SAMPLE_RATE_HZ), (3 * 16_000, 16_000), (1, SAMPLE_RATE_HZ), (90_000, SAMPLE_RATE_HZ)]
)
def test_silence_however_short_and_at_any_rate_has_an_answer(
    root: Path, wav: Path, weights: Path, samples: int, rate: int
) -> None:
    soundfile.write(wav, np.zeros((samples, 8)), rate)
    visitor = Visitor(root).open("filling")
    assert_answers(visitor, by_hand(root, weights))


def test_broken_or_missing_weights_leave_the_sound(
    root: Path, tmp_path: Path, weights: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    broken = tmp_path / "broken.safetensors"
    broken.write_bytes(weights.read_bytes()[:500])
    other = write_weights(tmp_path / "other.safetensors", channels=1)
    fused = write_fused(tmp_path)
    missing = tmp_path / "missing.safetensors"
    for path, words in (
        (broken, "is not a file"),
        (other, "1 × 128 features"),
        (fused, "hears arrays of 1 × 128 features; name their folder in CORSMAL_FEATURES"),
        (missing, "weights are missing"),
    ):
        monkeypatch.setenv("CORSMAL_FILLING_WEIGHTS", str(path))
        visitor = Visitor(root).open("filling")
        assert visitor.crashes == []
        (error,) = visitor.errors
        assert str(path) in error
        assert words in error
        assert visitor.count("audio") == 1
        assert set(visitor.plots) == {timeline.TIMELINE}
        assert len(visitor.plots[timeline.TIMELINE]["figure"]["data"]) == 3


def write_fused(folder: Path) -> Path:
    torch.manual_seed(2)
    model = FusedModel(FusedConfig((RecurrentConfig(hidden=2),), (PooledConfig(hidden=2),)))
    save_fused(folder / "fused.safetensors", model.eval())
    return folder / "fused.safetensors"


@pytest.fixture
def arrays(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> dict[str, Path]:
    """Arrays of three seconds of both senses, and a network for them."""
    rng, folders = np.random.default_rng(0), {}
    for name, shape in (("heard", (3, 128)), ("seen", (3, 5, 512))):
        folders[name] = tmp_path / name
        folders[name].mkdir()
        np.save(folders[name] / f"{NAME}.npy", rng.normal(size=shape).astype(np.float16))
    monkeypatch.setenv("CORSMAL_FILLING_WEIGHTS", str(write_fused(tmp_path)))
    monkeypatch.setenv("CORSMAL_FEATURES", os.pathsep.join(map(str, folders.values())))
    return folders


def by_both(arrays: dict[str, Path], *names: str, rows: dict[str, slice] | None = None) -> FusedPrediction:
    given = {
        name: np.load(arrays[name] / f"{NAME}.npy").astype(np.float32)[..., (rows or {}).get(name, slice(None)), :]
        for name in names
    }
    predictor = FusedPredictor(arrays["heard"].parent / "fused.safetensors")
    heard = given["heard"][None] if "heard" in given else None
    return predictor.predict(heard, sight=given.get("seen"))


def marks(visitor: Visitor, head: str) -> dict[str, list[float]]:
    return {trace["name"]: trace["x"] for trace in visitor.plots[f"answer_{head}"]["figure"]["data"][2:]}


def test_network_of_both_senses_answers_beside_what_each_of_them_says(noisy: Path, arrays: dict[str, Path]) -> None:
    visitor = Visitor(noisy).open("filling")
    expected = by_both(arrays, "heard", "seen")
    assert_answers(visitor, expected)
    for head in HEADS:
        own = marks(visitor, head)
        np.testing.assert_allclose(own["sound"], 100 * getattr(expected.sound, f"{head}_probabilities"), rtol=1e-4)
        np.testing.assert_allclose(own["sight"], 100 * getattr(expected.sight, f"{head}_probabilities"), rtol=1e-4)
    kind, sure = ("cup", "glass", "box")[expected.kind_probabilities.argmax()], 100 * expected.kind_probabilities.max()
    share = 100 * expected.sight_share
    assert f"{share:.0f} % sight, which recognises a {kind} ({sure:.0f} %)" in visitor.sentences
    gate = next(each for each in visitor.plots["senses"]["figure"]["data"] if each["name"] == "share of sight")
    assert gate["y"][-1] == pytest.approx(100 * expected.sight_share, rel=1e-4)
    assert "**Clip** of frames 0–15" in visitor.sentences


def test_crop_cuts_both_senses(noisy: Path, arrays: dict[str, Path]) -> None:
    visitor = Visitor(noisy).open("filling")
    visitor.report(timeline.TIMELINE, values={"crop_from": 0.9}, settled=True)
    rows = {"heard": slice(1, 3), "seen": slice(2, 5)}  # 0.96 s and 1.07 s are the first to begin later
    assert_answers(visitor, by_both(arrays, "heard", "seen", rows=rows))
    assert set(marks(visitor, "level")) == {"whole recording", "sound", "sight"}


@pytest.mark.parametrize(("there", "missing"), [("heard", "sight"), ("seen", "sound")])
def test_a_sense_that_is_missing_is_said_in_a_sentence(
    noisy: Path, arrays: dict[str, Path], there: str, missing: str
) -> None:
    other = arrays["seen" if there == "heard" else "heard"]
    (other / f"{NAME}.npy").rename(other / "000009.npy")
    visitor = Visitor(noisy).open("filling")
    assert_answers(visitor, by_both(arrays, there))
    assert f"**No {missing}**: recording {NAME} has no features" in visitor.sentences
    assert not marks(visitor, "level")  # what there is said is the answer itself


def test_a_recording_without_sound_is_answered_from_its_videos(
    noisy: Path, wav: Path, arrays: dict[str, Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    wav.unlink()
    monkeypatch.setenv("CORSMAL_FEATURES", str(arrays["seen"]))
    (arrays["heard"].parent / "fused.safetensors").unlink()
    torch.manual_seed(2)
    model = FusedModel(FusedConfig((FillingConfig(**SMALL),), (PooledConfig(hidden=2),)))
    save_fused(arrays["heard"].parent / "fused.safetensors", model.eval())
    visitor = Visitor(noisy).open("filling")
    assert_answers(visitor, by_both(arrays, "seen"))
    assert "**No sound**: recording 000000 has no sound" in visitor.sentences
    assert timeline.TIMELINE not in visitor.plots


def test_weights_of_the_demo_are_said_to_be_of_synthetic_sound(
    root: Path, weights: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("CORSMAL_FILLING_WEIGHTS")
    monkeypatch.setattr("corsmal.weights.bundled_path", lambda _kind: weights)
    visitor = Visitor(root).open("filling")
    (warning,) = visitor.warnings
    assert "synthetic sound" in warning
    assert "python -m corsmal train filling" in warning


def test_authors_network_answers_with_its_own_front_end_and_is_named(
    noisy: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = write_released(tmp_path)["filling"]
    monkeypatch.setenv("CORSMAL_FILLING_WEIGHTS", str(path))
    visitor = Visitor(noisy).open("filling")
    samples, rate_hz = soundfile.read(noisy / "audio" / f"{NAME}.wav", dtype="float32")
    types, levels = released.logits(path, samples.T, sample_rate_hz=rate_hz)
    assert_answers(visitor, FillingPrediction(types.astype(float), levels.astype(float)))
    assert len(visitor.plots[timeline.TIMELINE]["figure"]["data"]) > 3
    assert "task1and2.pt" in visitor.sentences
    assert "no answer to a recording of that set is held out" in visitor.sentences


def test_what_the_authors_network_cannot_hear_or_is_not_is_a_sentence(
    root: Path, wav: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    paths = write_released(tmp_path)
    soundfile.write(wav, np.zeros((SAMPLE_RATE_HZ, 8), np.int16), SAMPLE_RATE_HZ)
    for path, words in (
        (paths["filling"], "the sound is silent in a microphone at 0.00 s"),
        (paths["mass"], "is the mass network's file, not the filling network's"),
    ):
        monkeypatch.setenv("CORSMAL_FILLING_WEIGHTS", str(path))
        visitor = Visitor(root).open("filling")
        assert visitor.crashes == []
        (error,) = visitor.errors
        assert error.startswith("No prediction: ")
        assert words in error


def picture_caption(visitor: Visitor) -> str:
    notes = visitor.plots[timeline.TIMELINE]["figure"]["layout"]["annotations"]
    [text] = [note["text"] for note in notes if note["text"].startswith("<b>Log-mel</b>")]
    return str(text)


def drawn(root: Path) -> tuple[np.ndarray, str]:
    """The picture's pixels, with its caption."""
    visitor = Visitor(root).open("filling")
    assert visitor.crashes == []
    [image] = visitor.plots[timeline.TIMELINE]["figure"]["layout"]["images"]
    content = np.frombuffer(base64.b64decode(image["source"].partition(",")[2]), np.uint8)
    return cv2.imdecode(content, cv2.IMREAD_COLOR), picture_caption(visitor)


def test_log_mel_is_drawn_by_the_front_end_of_the_network_that_speaks(
    root: Path, wav: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    samples = np.random.default_rng(0).normal(0, 0.1, (2 * SAMPLE_RATE_HZ, 8))
    samples[SAMPLE_RATE_HZ:] = 0
    soundfile.write(wav, samples, SAMPLE_RATE_HZ, subtype="FLOAT")
    papers, caption = drawn(root)
    assert caption.startswith("<b>Log-mel</b> by the paper's front end: ln power")
    assert papers[8, -10].max() < 40
    monkeypatch.setenv("CORSMAL_FILLING_WEIGHTS", str(write_released(tmp_path)["filling"]))
    authors, caption = drawn(root)
    assert caption.startswith("<b>Log-mel</b> by the authors' front end: log₂ power")
    assert caption.endswith("grey: silence")
    np.testing.assert_allclose(authors[8, -10], 128, atol=6)
    np.testing.assert_allclose(authors[:, 8:32], papers[:, 8:32], atol=12)


def test_what_is_drawn_and_not_heard_says_so(
    root: Path, wav: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    of_arrays, authors = write_weights(tmp_path / "one.safetensors", channels=1), write_released(tmp_path)["filling"]
    for path, seconds, words in (
        (of_arrays, 1.0, "the network is given arrays"),
        (authors, 0.02, "too short for the authors' front end"),
    ):
        write_audio(wav, seconds=seconds)
        monkeypatch.setenv("CORSMAL_FILLING_WEIGHTS", str(path))
        assert f"by the paper's front end ({words}): ln" in drawn(root)[1]


def test_recording_without_annotation_has_an_answer_without_a_verdict(root: Path) -> None:
    (root / "ccm_tiny_annotation.json").unlink()
    visitor = Visitor(root).open("filling")
    assert visitor.crashes == visitor.errors == []
    assert [metric.delta for metric in visitor.test.metric] == ["no annotation"] * 2


def test_real_recording_is_heard(real_root: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # the start page would copy four videos
    monkeypatch.setattr(media, "playable_video", lambda view, **_: view.video_path)
    visitor = Visitor(real_root, recording="000618").open("filling")
    assert visitor.crashes == visitor.errors == visitor.warnings == []
    assert span_of(visitor) == (0, 2.65)
