"""Detections read and scored. Compare the rows of one run."""

import json
from functools import partial

import numpy as np
import pyarrow.parquet as pq
import pycocotools.mask as coco_mask
import pytest

from corsmal.detection import Detections, ViewDetections, read_coco_results, write_coco_results
from corsmal.detection.parquet import read_parquet, write_parquet
from corsmal.digests import digest
from corsmal.parameters import PAIRS, SelectionParameters
from corsmal.selection import score_frames, select_best_frame
from corsmal.stages.detections import load_detections

FRAMES, PER_FRAME = 300, 10
PAIR = PAIRS[0]

reading = pytest.mark.benchmark(group="read detections", max_time=0.5)
reading_many = pytest.mark.benchmark(group="read many detections", max_time=0.5)
reading_kept = pytest.mark.benchmark(group="read kept detections", max_time=0.5)
keeping = pytest.mark.benchmark(group="keep detections", max_time=0.5)
scoring = pytest.mark.benchmark(group="score", max_time=0.5)


@reading
def test_read_the_files_of_three_views(benchmark, recording, store):
    assert len(benchmark(load_detections, recording, store=store).views) >= 3


@reading
def test_bare_parsing_of_the_json(benchmark, recording):
    paths = [view.detections_path for view in recording.views.values() if view.detections_path]
    assert benchmark(lambda: [json.loads(path.read_bytes()) for path in paths])


@pytest.fixture(scope="module")
def many(opened):
    """As much as COCO's detector finds in ten seconds: ten detections in each of 300 frames."""
    found = opened.found.views["view3"]
    records = [record for record in found.values() if len(record)]
    by_frame = {}
    for frame in range(FRAMES):
        chosen = [records[(frame + index) % len(records)] for index in range(PER_FRAME)]
        columns = [np.concatenate([getattr(one, name)[:1] for one in chosen]) for name in ("boxes", "scores", "labels")]
        by_frame[frame] = Detections.from_counts(*columns, [one.counts[0] for one in chosen], size=found.size)
    return ViewDetections(by_frame, size=found.size, source="a test")


@pytest.fixture(scope="module")
def many_path(many, tmp_path_factory):
    path = tmp_path_factory.mktemp("many") / "000001.json"
    write_coco_results(many, path)
    return path


@reading_many
def test_read_a_file_of_3000_detections(benchmark, many, many_path):
    found = benchmark(lambda: read_coco_results(many_path, size=many.size, frame_count=FRAMES))
    assert sum(map(len, found.values())) == FRAMES * PER_FRAME


@reading_many
def test_bare_parsing_of_the_json_of_3000(benchmark, many_path):
    assert benchmark(lambda: json.loads(many_path.read_bytes()))


def kept(many, store):
    path = store.file("detections", digest("many"), ".parquet")
    assert store.write(path, partial(write_parquet, many))
    return path


@reading_kept
@pytest.mark.goal(ratio=5)
def test_read_3000_kept_detections(benchmark, many, store):
    path = kept(many, store)
    assert len(benchmark(store.read, path, partial(read_parquet, is_own=True))) == FRAMES


@reading_kept
def test_bare_reading_of_the_table_by_pyarrow(benchmark, many, store):
    path = kept(many, store)
    assert len(benchmark(lambda: pq.read_table(path).to_pydict()["score"])) == FRAMES * PER_FRAME


@keeping
def test_keep_3000_detections(benchmark, many, store):
    assert benchmark(kept, many, store)


@keeping
def test_bare_writing_of_the_table_by_pyarrow(benchmark, many, store, tmp_path):
    table = pq.read_table(kept(many, store))
    benchmark(lambda: pq.write_table(table, tmp_path / "part", compression="zstd"))


@scoring
@pytest.mark.goal(ratio=5)
def test_view_scores_of_all_frames(benchmark, opened):
    scores = benchmark(score_frames, opened.found.views, pair=PAIR, centre_rule=opened.best.centre_rule)
    assert any(score.total for score in scores)


@scoring
@pytest.mark.goal(ratio=5)
def test_select_the_best_frame(benchmark, opened):
    assert benchmark(select_best_frame, opened.found.views, pair=PAIR).ok


@scoring
def test_bare_areas_of_the_masks_by_pycocotools(benchmark, opened):
    frames = [frame for view in PAIR for frame in opened.found.views[view].values()]
    rles = [[{"size": list(frame.size), "counts": counts} for counts in frame.counts] for frame in frames]
    assert benchmark(lambda: [coco_mask.area(part) for part in rles])


@scoring
def test_select_the_best_frame_by_the_released_program(benchmark, opened):
    """Of all frames: it counts one per second only."""
    released = SelectionParameters.released()
    assert benchmark(select_best_frame, opened.found.views, pair=PAIR, parameters=released).ok
