from dataclasses import fields, replace

from corsmal.dataset import open_dataset
from corsmal.estimation import estimate, file_detections
from corsmal.parameters import SelectionParameters, ShapeParameters
from corsmal.runs.rules import (
    ALONE,
    IN_TURN,
    RULES,
    comparable,
    compare_rules,
    conditions,
    load_rules,
)


def test_every_rule_of_the_program_is_switched_once():
    paper, released = ShapeParameters.paper(), ShapeParameters.released()
    different = {each.name for each in fields(paper) if getattr(paper, each.name) != getattr(released, each.name)}
    assert sorted(name for names in RULES.values() for name in names) == sorted(different)


def test_one_rule_after_the_other_leads_to_the_program():
    found = conditions()
    assert list(found)[:4] == ["paper", "released", "lode", "tuned"]
    assert found[f"{IN_TURN}{list(RULES)[-1]}"] == found["released"]
    heights = found[f"{ALONE}heights"].shape
    assert heights == replace(ShapeParameters.paper(), circumferences=500, height_range=heights.height_range)
    assert found[f"{ALONE}selection"].shape == ShapeParameters.paper()
    assert found[f"{ALONE}selection"].selection == SelectionParameters.released()
    assert found["lode"].selection == SelectionParameters.paper()


def test_rows_are_those_of_the_estimates(tiny_dataset_root, store):
    dataset = open_dataset(tiny_dataset_root)
    assert [each.id for each in comparable(dataset, store=store)] == [
        "000000",
        "000001",
    ]  # the others have no detections
    rows = compare_rules([dataset["000000"]], store=store)
    views, _ = file_detections(dataset["000000"])
    for name in ("paper", "released", f"{ALONE}height rule"):
        condition = conditions()[name]
        expected = estimate(
            dataset["000000"], detections=views, shape=condition.shape, selection=condition.selection
        ).row()
        assert rows[name] == [expected]
    assert load_rules(dataset, store=store) is None  # one is missing
    compare_rules([dataset["000001"]], store=store)
    kept = load_rules(dataset, store=store)
    assert kept["paper"][0] == rows["paper"][0]
    assert len(kept["released"]) == 2
