import pandas as pd

from corsmal.figures import score_figure
from corsmal.figures.scores import score_error_figure
from corsmal.selection import BestFrame, FrameScore
from tests.figures.made import traces

PAIR = ("view3", "view1")
SCORES = (
    FrameScore(0, (600, 250), (100, 2)),
    FrameScore(1, (700, None), (40, 0)),
    FrameScore(4, (900, 500), (0, 0)),
)
BEST = BestFrame(PAIR, 4, "horizontal third", SCORES)


def test_every_part_of_every_frame_is_drawn():
    found = traces(score_figure(BEST))
    assert all(trace.x == (0, 1, 4) for name, trace in found.items() if "best" not in name)
    assert found["N, view3"].y == (600, 700, 900)
    assert found["N, view1"].y == (250, None, 500)
    # both views' S lose both views' TP: 600 + 250 - 2 * (100 + 2)
    assert found["penalties, twice both views' TP"].y == (-204, None, 0)
    assert found["score of the pair"].y == (646, None, 1400)


def test_the_parts_add_up_to_the_score():
    found = traces(score_figure(BEST))
    parts = [found[name].y for name in ("N, view3", "N, view1", "penalties, twice both views' TP")]
    for first, second, penalty, total in zip(*parts, found["score of the pair"].y, strict=True):
        assert total is None or first + second + penalty == total


def test_the_best_frame_is_marked():
    star = traces(score_figure(BEST))["best frame: 4"]
    assert (star.x, star.y, star.marker.symbol) == ((4,), (1400,), "star")


def test_no_best_frame_and_no_inspected_frame_are_drawn_too():
    none = BestFrame(PAIR, None, "none", SCORES[1:2], "none of 1 inspected frames shows a container in both")
    assert not any("best" in name for name in traces(score_figure(none)))
    empty = score_figure(BestFrame(PAIR, None, "none", (), "no inspected frame"))
    assert [trace.x for trace in empty.data] == [()] * 4


def test_every_frame_is_a_point_of_its_container():
    table = pd.DataFrame(
        {
            "container": ["red cup", "red cup", "flute"],
            "recording": ["000000", "000000", "000005"],
            "frame": [0, 3, 0],
            "score": [900, 700, 300],
            "error_pct": [12.0, 15.0, 40.0],
        }
    )
    found = traces(score_error_figure(table))
    assert found.keys() == {"red cup", "flute"}
    assert list(found["red cup"].x) == [900, 700]
    assert list(found["red cup"].y) == [12, 15]
    assert found["flute"].customdata.tolist() == [["000005", 0]]
