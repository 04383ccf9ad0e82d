import base64
import itertools
from dataclasses import replace

import cv2
import numpy as np
import pytest

from corsmal.errors import ArgumentError
from corsmal.figures.answer import answer_figure
from corsmal.figures.sound import ENVELOPE_POINTS, LOG_MEL_DB, PICTURE_WIDTH, band_of, sound_picture
from corsmal.figures.style import LEVEL_COLOURS, TYPE_COLOURS
from corsmal.figures.timeline import TRAINING_CROPS, timeline_figure
from corsmal.filling import LEVEL_NAMES, TYPE_NAMES, FillingPrediction
from corsmal.filling.samples import CROP_END_MIN, CROP_START_MAX

RATE_HZ = 100
ROW_S = 0.1
SILENCE = -23.0
"""Below the darkest colour, as a natural logarithm."""


def made_picture(*, samples=200, rows=20, bands=16):
    waveform = np.zeros(samples, dtype=np.float32)
    waveform[50], waveform[120] = 0.5, -0.25
    values = np.full((rows, bands), SILENCE, dtype=np.float32)
    values[5:10, 12:] = 10
    return sound_picture(waveform, values, sample_rate_hz=RATE_HZ, row_s=ROW_S, highest_hz=8000)


def logits(*shares):
    return np.log(np.array(shares))


def made_prediction(types=(0.1, 0.2, 0.3, 0.4), levels=(0.2, 0.5, 0.3), *, rows=(0, 20)):
    attention = np.full(rows[1] - rows[0], 1.0)
    attention[3] = 6
    return FillingPrediction(
        logits(*types), logits(*levels), attention=attention / attention.sum(), steps_s=ROW_S, rows=rows
    )


def made_windows():
    """Nothing, then rice."""
    shares = [(0.97, 0.01, 0.01, 0.01)] * 6 + [(0.1, 0.1, 0.7, 0.1)] * 5
    return [made_prediction(share, rows=(start, start + 10)) for start, share in enumerate(shares)]


def decoded(picture):
    content = np.frombuffer(base64.b64decode(picture.log_mel.removeprefix("data:image/jpeg;base64,")), np.uint8)
    return cv2.imdecode(content, cv2.IMREAD_COLOR).astype(int).sum(axis=2)


def of_axis(figure, name):
    """The traces of one panel, counted from above."""
    return [trace for trace in figure.data if (trace.yaxis or "y") == name]


def texts(figure):
    return [annotation.text for annotation in figure.layout.annotations]


def test_every_sample_of_a_short_waveform_is_drawn_at_its_time():
    picture = made_picture()
    assert len(picture.times_s) == 200
    assert picture.times_s[50] == pytest.approx(0.505)
    assert (picture.low[50], picture.high[50], picture.low[120]) == (0.5, 0.5, -0.25)
    assert picture.duration_s == 2.0


def test_a_long_waveform_keeps_its_extremes():
    samples = np.zeros(100_000, dtype=np.float32)
    samples[70_001], samples[70_002] = 0.9, -0.8
    picture = sound_picture(samples, np.zeros((4, 8)), sample_rate_hz=1000, row_s=25, highest_hz=500)
    assert len(picture.times_s) == ENVELOPE_POINTS
    place = np.abs(picture.times_s - 70.0015).argmin()
    assert (picture.high[place], picture.low[place]) == (np.float32(0.9), np.float32(-0.8))
    assert np.count_nonzero(picture.high) == np.count_nonzero(picture.low) == 1


def test_log_mel_is_bright_where_it_is_loud_with_low_bands_at_the_bottom():
    picture = made_picture()
    image = decoded(picture)
    assert image.shape == (16, 20)
    assert image[1, 7] > 500
    assert max(image[14, 7], image[1, 17]) < 60
    assert picture.span_s == pytest.approx((-0.05, 1.95))


def test_a_long_recording_is_a_picture_of_bounded_width():
    picture = sound_picture(np.zeros(9, np.float32), np.zeros((7000, 4)), sample_rate_hz=9, row_s=1, highest_hz=4)
    assert decoded(picture).shape == (4, PICTURE_WIDTH)


def test_colours_are_of_power_in_decibels_alike_for_all():
    low, high = (np.full((1, 1), value * np.log(10) / 10, np.float32) for value in LOG_MEL_DB)
    beyond = [np.full((1, 1), value, np.float32) for value in (-99, 99)]
    images = [
        decoded(sound_picture(np.zeros(1, np.float32), rows, sample_rate_hz=1, row_s=1, highest_hz=1))
        for rows in (low, beyond[0], high, beyond[1])
    ]
    assert images[0] == images[1]
    assert images[2] == images[3]


def made_of(rows, **options):
    rows = np.asarray(rows, np.float32)
    return sound_picture(np.zeros(1, np.float32), rows, sample_rate_hz=1, row_s=1, highest_hz=1, **options)


def test_each_front_end_has_its_logarithm_and_the_same_colour_for_the_same_power():
    powers = np.logspace(-4, 1, 12).reshape(3, 4)
    papers, authors = made_of(np.log(powers)), made_of(np.log2(powers), logarithm="binary", source="another")
    np.testing.assert_allclose(decoded(papers), decoded(authors), atol=9)  # rounding before the JPEG
    assert (papers.unit, papers.limits) == ("ln", pytest.approx((np.log(1e-4), np.log(10**1.5))))
    assert (authors.unit, authors.limits) == ("log₂", pytest.approx((np.log2(1e-4), np.log2(10**1.5))))
    for picture, caption in (
        (papers, "<b>Log-mel</b> by the paper's front end: ln power, dark −9 to bright 3"),
        (authors, "<b>Log-mel</b> by another: log₂ power, dark −13 to bright 5"),
    ):
        assert caption in texts(timeline_figure(picture, channel=""))


def test_silence_without_a_number_is_grey_and_said():
    rows = np.full((64, 32), -5.0)
    rows[32:] = -np.inf
    picture = made_of(rows, logarithm="binary")
    content = np.frombuffer(base64.b64decode(picture.log_mel.removeprefix("data:image/jpeg;base64,")), np.uint8)
    image = cv2.imdecode(content, cv2.IMREAD_COLOR)
    np.testing.assert_allclose(image[8, 52], [128, 128, 128], atol=6)
    assert np.ptp(image[8, 10].astype(int)) > 60
    assert any("grey: silence" in text for text in texts(timeline_figure(picture, channel="")))
    assert not made_of(rows[:32]).has_silence


def test_bands_are_equally_spaced_on_the_mel_scale():
    highest_mel = 2595 * np.log10(1 + 8000 / 700)
    for band in (0, 3, 15):
        frequency_hz = 700 * (10 ** (highest_mel * (band + 1) / 17 / 2595) - 1)
        assert band_of(frequency_hz, bands=16, highest_hz=8000) == pytest.approx(band)


@pytest.mark.parametrize(
    ("samples", "rows"),
    [(np.zeros(0), np.zeros((2, 3))), (np.zeros((1, 4)), np.zeros((2, 3))), (np.zeros(4), np.zeros((0, 3)))],
)
def test_nothing_to_draw_is_an_error(samples, rows):
    with pytest.raises(ArgumentError, match="not empty"):
        sound_picture(samples, rows, sample_rate_hz=1, row_s=1, highest_hz=1)


def test_timeline_without_a_network_has_the_sound_alone():
    figure = timeline_figure(made_picture(), channel="microphone 3")
    assert "yaxis3" not in figure.layout
    assert "<b>Waveform</b>, microphone 3" in texts(figure)
    assert len(figure.layout.meta["cropped"]) == 2
    image = figure.layout.images[0]
    assert (image.x, image.x + image.sizex) == pytest.approx((-0.05, 1.95))
    assert (image.y, image.y - image.sizey) == (15.5, -0.5)


def test_all_panels_share_one_time_axis_and_do_not_overlap():
    figure = timeline_figure(
        made_picture(), channel="mean of all", prediction=made_prediction(), windows=made_windows()
    )
    assert {trace.xaxis or "x" for trace in figure.data} == {"x"}
    domains = [figure.layout[f"yaxis{number}"].domain for number in ("", 2, 3, 4, 5)]
    assert all(above[0] > below[1] for above, below in itertools.pairwise(domains))
    assert domains[-1][0] == pytest.approx(0)
    assert [tuple(part) for part in figure.layout.meta["cropped"]] == [tuple(part) for part in domains[:3]]
    assert figure.layout.xaxis.title.text == "time (s)"


def test_attention_is_drawn_at_the_rows_of_the_crop_relative_to_its_mean():
    prediction = made_prediction(rows=(5, 15))
    (attention,) = of_axis(timeline_figure(made_picture(), channel="", prediction=prediction), "y3")
    np.testing.assert_allclose(attention.x, 0.1 * np.arange(5, 15), rtol=1e-6)
    np.testing.assert_allclose(attention.y, np.where(np.arange(10) == 3, 4.0, 10 / 15), rtol=1e-6)


def test_windows_are_drawn_at_their_middles_and_add_up():
    windows = made_windows()
    figure = timeline_figure(made_picture(), channel="", windows=windows)
    areas = {trace.name: trace for trace in of_axis(figure, "y3")}
    assert tuple(areas) == TYPE_NAMES
    np.testing.assert_allclose(areas["rice"].x, 0.45 + 0.1 * np.arange(11), rtol=1e-6)
    np.testing.assert_allclose(areas["rice"].y, [1.0] * 6 + [70.0] * 5, rtol=1e-5)
    np.testing.assert_allclose(sum(trace.y for trace in areas.values()), 100, rtol=1e-5)
    assert [areas[name].fillcolor for name in TYPE_NAMES] == list(TYPE_COLOURS.values())
    assert [trace.name for trace in of_axis(figure, "y4")] == list(LEVEL_NAMES)


def test_classes_are_named_inside_their_own_area():
    figure = timeline_figure(made_picture(), channel="", windows=made_windows())
    labels = {text.text: text for text in figure.layout.annotations if text.yref == "y3"}
    assert set(labels) == {"none", "rice"}
    assert labels["none"].x == pytest.approx(0.65)
    assert labels["rice"].x == pytest.approx(0.45 + 0.1 * 8)
    assert labels["rice"].y == pytest.approx(10 + 10 + 35)


def test_a_lone_window_is_drawn_over_its_whole_length():
    figure = timeline_figure(made_picture(), channel="", windows=[made_prediction(rows=(0, 10))])
    areas = of_axis(figure, "y3")
    np.testing.assert_allclose(areas[0].x, [0, 0.9], atol=1e-6)
    np.testing.assert_allclose(areas[0].y, [10, 10], rtol=1e-5)


def test_ranges_of_the_papers_crops_are_shown():
    assert [(low, high) for low, high, _ in TRAINING_CROPS] == [(0, CROP_START_MAX), (CROP_END_MIN, 1)]
    shapes = timeline_figure(made_picture(), channel="").layout.shapes
    assert [end for shape in shapes for end in (shape.x0, shape.x1)] == pytest.approx([0, 0.8, 1.2, 2.0])


def test_noise_does_not_fill_the_waveforms_axis():
    picture = made_picture()
    silent = replace(picture, low=0 * picture.low, high=0 * picture.high)
    assert timeline_figure(silent, channel="").layout.yaxis.range[1] == pytest.approx(0.0105)
    assert timeline_figure(picture, channel="").layout.yaxis.range[1] == pytest.approx(0.525)


def test_answer_has_probabilities_as_bars_and_logits_as_numbers():
    figure = answer_figure(made_prediction(), head="type", true="rice")
    bars, numbers = figure.data
    np.testing.assert_allclose(bars.x, [10, 20, 30, 40])
    assert list(bars.marker.color) == list(TYPE_COLOURS.values())
    assert list(numbers.text) == ["10 % (-2.3)", "20 % (-1.6)", "30 % (-1.2)", "40 % (-0.9)"]
    assert list(figure.layout.yaxis.ticktext) == ["none", "pasta", "<b>◆ rice</b>", "water"]
    assert figure.layout.yaxis.range == (3.5, -0.5)


def test_answer_marks_what_others_gave():
    beside = {"sound": made_prediction(), "whole recording": made_prediction(levels=(0.1, 0.1, 0.8))}
    figure = answer_figure(made_prediction(), head="level", beside=beside)
    assert [trace.name for trace in figure.data[2:]] == list(beside)
    assert figure.data[2].marker.symbol != figure.data[3].marker.symbol
    assert list(figure.data[0].marker.color) == list(LEVEL_COLOURS.values())
    np.testing.assert_allclose(figure.data[-1].x, [10, 10, 80])
    assert list(figure.layout.yaxis.ticktext) == list(LEVEL_NAMES)
