import csv
import json
from dataclasses import replace
from datetime import date

import pytest

from corsmal.dataset import open_dataset
from corsmal.dataset.clock import Matching
from corsmal.errors import ArgumentError
from corsmal.evaluation import export_table, read_estimates, write_estimates
from corsmal.figures.pins import Pin
from corsmal.figures.report import Commands, Table, Table2, report_html
from corsmal.parameters import ShapeParameters
from corsmal.quantities import MEASURED
from corsmal.runs import make_run
from corsmal.runs.judged import JudgedRun
from corsmal.runs.report import ROWS_MAX, run_report
from corsmal.runs.report_appendix import commands
from corsmal.stages.settings import default_settings
from tests.tiny import CONTAINERS, annotation_row, write_json


@pytest.fixture(scope="module")
def dataset(tiny_dataset_root):
    return open_dataset(tiny_dataset_root)


@pytest.fixture(scope="module")
def runs(dataset, tmp_path_factory):
    from corsmal.store import Store  # noqa: PLC0415

    store = Store(tmp_path_factory.mktemp("store"))
    shapes = {"first": ShapeParameters.paper(), "second": replace(ShapeParameters.paper(), max_difference_mm=2.0)}
    return {
        name: make_run(name, dataset, default_settings(dataset, shape=shape), store=store)
        for name, shape in shapes.items()
    }


def blocks_of(report, kind):
    return [block for section in report.sections for block in section.blocks if isinstance(block, kind)]


def test_it_says_what_was_tried_on_what_with_which_result_and_how_sure(dataset, runs):
    pin = Pin("A frame", content=b"x", medium="image/png")
    report = run_report(
        runs["second"], dataset, against=runs["first"], pins=[pin], author="A. Author", made=date(2026, 3, 1)
    )
    assert report.made == "1 March 2026"
    assert report.banner.kind == "Real recordings"
    assert "3 recordings of the dataset" in report.banner.text
    assert "000000, 000001, 000002" in report.banner.text
    headings = [section.heading for section in report.sections]
    assert headings == [
        "Summary",
        "Results by container",
        "Where the errors are",
        "CORSMAL Challenge",
        "Run second against run first",
        "Pinned views",
        "Recordings",
        "Appendix: parameters, digests, commands",
    ]
    answers = report.sections[0].blocks[0].by_question
    assert answers["What was tried"].startswith(
        "Run second: the shape is fitted with parameters of its own (L 145, d_max 2 mm)"
    )
    assert "no filling network was used" in answers["What was tried"]
    assert answers["On what"].startswith("3 real recordings of 3 containers: red cup, green glass, small white cup.")
    assert "for orientation, not for comparison" in answers["On what"]
    assert answers["With which result"].startswith("The capacity is off by ")
    assert "of 3 recordings failed" in answers["How sure"]
    assert "with only 3 recordings they are wide" in answers["How sure"]
    assert len(blocks_of(report, Table2)[0].cells) == 28
    page = report_html(report)
    for wrong in ("<NA>", "nan", "None", "filling_type", "capacity_ml"):
        assert wrong not in page.split('id="plotly"')[0].split("<main>")[1].replace("finance", ""), wrong


def test_recordings_are_listed_in_words_the_worst_first(dataset, runs):
    table = blocks_of(run_report(runs["first"], dataset), Table)[-3].table
    assert list(table.columns[:4]) == ["recording", "container", "status", "frame"]
    assert set(table["recording"]) == set(dataset.ids)
    assert table["Capacity (mL)"].str.fullmatch(r"[\d,]+\s\(([+−]\d+|0)\s%\)|").all()
    assert table["status"].iloc[-1].startswith("fitted")


def test_the_commands_of_the_appendix_name_preset_recordings_and_protocol(dataset, runs):
    lines = commands(JudgedRun(runs["first"], dataset, "paper"), against=None)
    root = dataset.name
    assert lines == [
        f"python -m corsmal estimate {root} --run first --preset paper --out first.csv",
        f"python -m corsmal runs export {root} first first.csv",
        f"python -m corsmal evaluate estimates {root} first.csv --protocol paper",
        f"python -m corsmal report {root} first --protocol paper --out report.html",
    ]
    hostile = replace(runs["second"], name="a; rm -rf $(b)", recordings=("000000",))
    lines = commands(JudgedRun(hostile, dataset, "held-out"), against=runs["first"])
    assert lines[0].startswith("# a; rm -rf $(b): no preset has its parameters")
    assert f"runs export {root} 'a; rm -rf $(b)' 'a; rm -rf $(b).csv'" in lines[2]
    settings = replace(
        runs["first"].settings,
        shape=replace(ShapeParameters.tuned(), wall_mm=2.5),
        matching=Matching(offsets_s=(("view1", 0.4),)),
    )
    judged = JudgedRun(replace(runs["first"], settings=settings), dataset, "held-out", ("any", "implausible"))
    lines = commands(judged, against=None)
    assert "--preset tuned --wall 2.5 --offset view1=0.4 " in lines[0]
    assert lines[2].endswith("--protocol held-out --without any --without implausible")
    assert "--without any --without implausible --out" in lines[3]
    by_number = replace(settings, matching=Matching(by="index"))
    assert "--match index" in commands(replace(judged, run=replace(judged.run, settings=by_number)), against=None)[0]
    assert len(blocks_of(run_report(runs["first"], dataset), Commands)) == 1


@pytest.mark.parametrize(
    "hostile", ["=cmd|' /C calc'!A0", "</script><script>alert(1)</script>", "a\nb & \\\\ www.x.org"]
)
def test_hostile_texts_of_files_stay_texts_in_tables_and_report(tiny_dataset_root, tmp_path, runs, hostile):
    root = tmp_path / "set"
    root.mkdir()
    content = json.loads((tiny_dataset_root / "ccm_tiny_annotation.json").read_text(encoding="utf-8"))
    content["containers"] = [{**container, "name": hostile, "type": hostile} for container in content["containers"]]
    write_json(root / "ccm_tiny_annotation.json", content)
    (root / "audio").symlink_to(tiny_dataset_root / "audio")
    dataset = open_dataset(root)
    rows = tuple({**row, "notes": hostile, "status": hostile, "pair": hostile} for row in runs["first"].rows)
    run = replace(runs["first"], rows=rows, note=hostile)
    page = report_html(run_report(run, dataset, title=hostile, author=hostile))
    assert "<script>alert" not in page
    assert "href" not in page.replace('<a href="#', "")
    write_estimates(run.table, tmp_path / "e.csv")
    for table in (run.table, read_estimates(tmp_path / "e.csv")):
        assert set(table["notes"]) == {hostile} or set(table["notes"]) == {f"'{hostile}"}
    lines = export_table(run.table[["recording_id", "notes"]], table_format="latex").splitlines()
    assert len([line for line in lines if line.endswith(r"\\")]) == 1 + len(run.table)
    with (tmp_path / "e.csv").open(encoding="utf-8", newline="") as file:
        assert not any(
            cell[:1] in tuple("=+-@") and not cell[1:2].isdigit() for row in csv.reader(file) for cell in row
        )


def test_flagged_rows_are_left_out_everywhere_and_named(dataset, runs):
    rows = tuple({**row, "flags": "implausible" * (row["recording_id"] == "000000")} for row in runs["first"].rows)
    report = run_report(replace(runs["first"], rows=rows), dataset, without=("implausible",))
    assert "2 recordings of the dataset" in report.banner.text
    notes = report.sections[1].blocks[1].sentences
    assert "1 of 3 rows raise a flag (implausible), left out: recording 000000." in notes
    assert set(blocks_of(report, Table)[-3].table["recording"]) == {"000001", "000002"}


def test_a_run_without_rows_of_the_dataset_is_one_sentence(dataset, runs):
    with pytest.raises(ArgumentError, match="estimates"):
        run_report(replace(runs["first"], rows=()), dataset)


def test_a_whole_test_set_stands_among_the_teams_with_intervals_and_coverage(tmp_path, runs):
    root = tmp_path / "test_pub"
    (root / "audio").mkdir(parents=True)
    rows = [annotation_row(number, CONTAINERS[number % 3]) for number in range(228)]
    write_json(root / "ccm_test_annotation.json", {"annotations": rows})
    whole = open_dataset(root)
    estimates = [
        {"recording_id": name, "status": "fitted", "filling_held_out": True, "mass_held_out": True, "notes": "a; b"}
        | {key: float(known[key]) for key in (*MEASURED, "filling_type", "filling_level")}
        | {"height_mm": 1.1 * known["height_mm"], "height_mm_low": 1.0, "height_mm_high": 2.0 + place % 2 * 500}
        for place, (name, known) in enumerate(whole.table.iterrows())
    ]
    run = replace(runs["first"], recordings=tuple(whole.ids), rows=tuple(estimates))
    report = run_report(run, whole)
    by_heading = {section.heading: section.blocks for section in report.sections}
    [board, *_] = by_heading["CORSMAL Challenge"]
    assert board.table["team"].iloc[0] == "first (this run)"
    assert len(board.table) > 5
    assert "public test set" in report.banner.text
    tiles = {tile.title: tile for tile in by_heading["Summary"][1].tiles}
    [height] = [line for line in tiles["MAPE ↓"].lines if line.label == "Height"]
    assert (height.value, height.tone) == ("10.0 %", "")  # the paper's table is of other recordings
    whole_coverage, height = tiles["Coverage of the 90 % intervals"].lines
    assert (height.label, height.value, height.tone) == ("Height", "50 %", "worse")
    assert whole_coverage.note == "114 of 228"
    _, listed_rows, notes = by_heading["Recordings"]
    assert len(listed_rows.table) == ROWS_MAX
    assert notes.sentences == [f"{note}: recordings 000000, 000001, 000002 and 225 more." for note in "AB"]
