import numpy as np
import pytest

from corsmal.figures.senses import senses_figure
from corsmal.filling import FillingPrediction, FusedPrediction

HALF = FillingPrediction(np.log([0.1, 0.2, 0.3, 0.4]), np.log([0.1, 0.8, 0.1]))
FULL = FillingPrediction(np.log([0.1, 0.2, 0.3, 0.4]), np.log([0.1, 0.2, 0.7]))


def fused(sound: FillingPrediction | None, sight: FillingPrediction | None, share: float) -> FusedPrediction:
    own = sound or sight
    return FusedPrediction(own.type_logits, own.level_logits, sound=sound, sight=sight, sight_share=share)


def captions(figure) -> list[str]:
    return [note.text for note in figure.layout.annotations if note.text.startswith("<b>")]


def test_each_sense_has_its_panel_from_the_time_it_is_there_and_the_gate_where_both_are():
    moments = [(1.0, fused(None, FULL, 1.0)), (2.0, fused(HALF, FULL, 0.25)), (3.0, fused(HALF, FULL, 0.5))]
    figure = senses_figure(moments, duration_s=3.0)
    [gate] = [trace for trace in figure.data if trace.name == "share of sight"]
    assert (gate.x, gate.y) == ((2.0, 3.0), (25, 50))
    full = [trace for trace in figure.data if trace.name == "full"]
    assert [len(trace.x) for trace in full] == [2, 3, 2]  # sound, sight, both
    assert full[1].y == pytest.approx((70, 70, 70))
    assert len({trace.stackgroup for trace in full}) == 3
    assert len(captions(figure)) == 4


@pytest.mark.parametrize(("sound", "sight", "word"), [(HALF, None, "sound"), (None, FULL, "videos")])
def test_a_sense_that_is_missing_has_no_panel_and_there_is_no_gate(sound, sight, word):
    figure = senses_figure([(1.0, fused(sound, sight, float(sound is None)))], duration_s=1.0)
    [caption] = captions(figure)
    assert word in caption
