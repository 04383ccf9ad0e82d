"""What records show of themselves in a notebook."""

import re

import numpy as np

from corsmal.dataset import open_dataset
from corsmal.estimation import estimate
from corsmal.notebook import outline_svg, record_html
from corsmal.runs import make_run
from corsmal.shape import Hull
from corsmal.stages.settings import EstimateSettings


def facts_of(html: str) -> dict[str, str]:
    return dict(re.findall(r"<tr><th[^>]*>(.*?)</th><td[^>]*>(.*?)</td></tr>", html))


def test_texts_are_escaped_and_empty_facts_left_out():
    html = record_html("a < b", {"name": "<i>", "nothing": ""}, notes=["x & y"])
    assert "<b>a &lt; b</b>" in html
    assert facts_of(html) == {"name": "&lt;i&gt;"}
    assert "<li>x &amp; y</li>" in html


def test_an_outline_has_both_sides_and_its_top_above():
    assert outline_svg([0.0], [10.0]) == ""
    svg = outline_svg([100.0, 150.0], [20.0, 30.0])
    assert "points='20.0,50.0 30.0,0.0 -30.0,0.0 -20.0,50.0'" in svg


def test_a_hull_shows_how_much_was_fitted():
    hull = Hull(
        heights_mm=np.array([0.0, 50.0, 100.0]),
        radii_mm=np.array([30.0, 40.0, 2.5]),
        converged=np.array([True, True, False]),
        centroid_m=np.zeros(3),
    )
    assert facts_of(hull._repr_html_()) == {
        "fitted": "2 of 3 circumferences",
        "heights": "0 to 50 mm",
        "radii": "30.0 to 40.0 mm",
    }
    failed = Hull.failed("no mask")._repr_html_()
    assert facts_of(failed)["failed"] == "no mask"
    assert "<svg" not in failed


def test_a_recording_shows_what_it_has_and_lacks(tiny_dataset_root):
    dataset = open_dataset(tiny_dataset_root)
    facts = facts_of(dataset["000000"]._repr_html_())
    assert facts["views"] == ", ".join(dataset["000000"].views)
    assert facts["capacity"] == f"{dataset['000000'].annotation.capacity_ml:g} mL"
    assert "missing" not in facts
    assert facts_of(dataset["000001"]._repr_html_())["missing"] == "view2 video, audio"


def test_an_estimate_and_a_run_show_their_numbers(tiny_dataset_root, store):
    dataset = open_dataset(tiny_dataset_root)
    found = estimate(dataset["000000"])
    facts = facts_of(found._repr_html_())
    assert facts["status"] == "fitted"
    assert facts["capacity"] == f"{found.capacity_ml:.0f} mL"
    assert facts["container mass"] == "unknown"
    run = make_run("first", dataset, EstimateSettings(), store=store, recordings=("000000",))
    html = run._repr_html_()
    assert "<b>Run first</b>" in html
    assert facts_of(html)["status"] == "1 fitted"
