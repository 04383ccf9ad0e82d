import pytest

from corsmal.dataset import open_dataset
from corsmal.errors import NotFoundError
from corsmal.estimation import fit_frame
from corsmal.parameters import PAIRS
from corsmal.quantities import GEOMETRY
from corsmal.runs.view_scores import score_errors
from corsmal.stages.true_masks import true_views
from corsmal.synthetic.writing.dataset import write_demo


@pytest.fixture(scope="module")
def synthetic(tmp_path_factory):
    root = tmp_path_factory.mktemp("synthetic") / "demo"
    write_demo(root, containers=(1,), recordings_per_container=1, size=(320, 180), workers=0)
    return open_dataset(root)


def test_scores_stand_beside_errors(synthetic):
    table = score_errors(synthetic, step=4)
    assert len(table) > 3
    assert (table["score"] > 0).all()
    assert table["rank"].between(0, 1).all()
    first, recording = table.iloc[0], synthetic["000000"]
    rule = "horizontal third"
    fit = fit_frame(recording, true_views(recording), pair=PAIRS[0], frame=int(first["frame"]), centre_rule=rule)
    true = {"capacity_ml": 520, "width_top_mm": 98, "width_bottom_mm": 61, "height_mm": 119}
    errors = [100 * abs(getattr(fit.dimensions, name) - true[name]) / true[name] for name in GEOMETRY]
    assert first["error_pct"] == pytest.approx(sum(errors) / 4)


def test_recordings_without_truth_are_refused(dataset):
    with pytest.raises(NotFoundError, match="only synthetic recordings"):
        score_errors(dataset)
