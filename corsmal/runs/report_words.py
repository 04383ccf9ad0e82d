"""The first page of a run's report in words and tiles."""

from collections.abc import Sequence

from corsmal.evaluation import STAMPS, Headline
from corsmal.evaluation.splits import SPLIT_NAMES
from corsmal.evaluation.summary import ALL, NOMINAL_PERCENT
from corsmal.evaluation.typesetting import UNLIKE
from corsmal.figures.report import Banner, Tile, TileLine, Tiles
from corsmal.figures.report.blocks import Tone
from corsmal.runs.judged import JudgedRun
from corsmal.runs.run import OWN
from corsmal.weights import WeightsFile

FEW = 30
"""With fewer recordings the intervals are wide."""
IDS_MAX = 8
DETECTORS = {"coco": "Mask R-CNN with COCO's weights", "demo": "the demo's small network"}


def banner(judged: JudgedRun) -> Banner:
    """Where the data come from, and what the numbers must not be taken for."""
    count, whole, name = len(judged.errors), len(judged.dataset), judged.dataset.name
    which = f"{_counted(count, 'recording')} of the dataset {name}" + (f", which has {whole}" if whole != count else "")
    ids = list(judged.errors.index)
    shown = ", ".join(ids[:IDS_MAX]) + (f" and {len(ids) - IDS_MAX} more" if len(ids) > IDS_MAX else "")
    stamp = STAMPS[judged.protocol]
    is_in_sample = judged.protocol == "in-sample"
    if judged.is_synthetic is False:
        found = judged.split.split
        of = "" if found == "other" else f" ({SPLIT_NAMES[found]})"
        return Banner("Real recordings", f"{which}{of}: {shown}. {stamp}", is_in_sample)
    kind = "Synthetic data" if judged.is_synthetic else "Real and synthetic recordings together"
    rendered = "Rendered scenes and sounds, no people" if judged.is_synthetic else "Some scenes are rendered"
    limit = "they show how the method works, not how well it does on real recordings"
    return Banner(kind, f"{rendered}: {which} ({shown}); {limit}. {stamp}", is_warning=True)


def answers(judged: JudgedRun) -> dict[str, str]:
    """What a reader asks first."""
    return {
        "What was tried": _tried(judged),
        "On what": _on_what(judged),
        "With which result": _result(judged.headlines),
        "How sure": _sure(judged),
    }


def _tried(judged: JudgedRun) -> str:
    run, settings = judged.run, judged.run.settings
    preset, _, numbers = run.facts()["parameters"].partition(" (")
    name = "parameters of its own" if run.preset == OWN else f"the preset {preset}"
    parts = [f"the shape is fitted with {name} ({numbers}"]
    for kind, file, what in (
        ("filling", settings.filling, "filling type and level"),
        ("mass", settings.mass, "the container's mass"),
    ):
        parts.append(f"no {kind} network was used" if file is None else f"{_network(file)} predicts {what}")
    detector = settings.detector
    found = "existing detections are used"
    if detector is not None:
        network = DETECTORS.get(detector.method, detector.method)
        found = f"containers are detected by {network} at steps of {detector.every} frames"
    return f"Run {run.name}: {'; '.join([*parts, found])}."


def _network(file: WeightsFile) -> str:
    return f"the bundled {file.kind} network" if file.is_bundled else f"the {file.kind} network {file.path.name}"


def _on_what(judged: JudgedRun) -> str:
    errors = judged.errors
    names = [name for name in errors["container"].drop_duplicates() if name]
    kind = {True: "synthetic ", False: "real ", None: ""}[judged.is_synthetic]
    shown = ", ".join(names[:9]) + (f" and {len(names) - 9} more" if len(names) > 9 else "")
    what = f"{_counted(len(errors), f'{kind}recording')} of {_counted(len(names), 'container')}: {shown}."
    if judged.is_like_with_like:
        return what
    if judged.split.split == "train":
        whole = len(judged.dataset)
        return (
            f"{what} The paper's numbers are of all {whole} recordings of this set: beside {len(errors)} of them they "
            "are for orientation, not for comparison."
        )
    return f"{what} {UNLIKE}"


def _result(headlines: Sequence[Headline]) -> str:
    by_name = {each.name: each for each in headlines if each.group in ("MAPE", "MPF1") and each.value is not None}
    sentences = []
    if "capacity_mape" in by_name:
        mean = " on average" if by_name["capacity_mape"].total > 1 else ""
        sentences.append(f"The capacity is off by {_percent(by_name['capacity_mape'])}{mean}")
    sizes = [by_name[name] for name in ("width_top_mape", "width_bottom_mape", "height_mape") if name in by_name]
    if sizes:
        low, high = (pick(each.value or 0.0 for each in sizes) for pick in (min, max))
        sentences.append(f"widths and height by {low:.1f} to {high:.1f} %")
    if "mass_mape" in by_name:
        sentences.append(f"the container's mass by {_percent(by_name['mass_mape'])}")
    text = ", ".join(sentences)
    classes = [
        f"{_percent(by_name[f'filling_{name}_mpf1'])} for the {name}"
        for name in ("level", "type")
        if f"filling_{name}_mpf1" in by_name
    ]
    if classes:
        text += f"{'. ' if text else ''}The F1-score of the filling is {' and '.join(classes)}"
    return f"{text}." if text else "Nothing could be compared with the annotation."


def _sure(judged: JudgedRun) -> str:
    count = len(judged.errors)
    coverage = next(each for each in judged.headlines if each.group == "coverage" and each.name == ALL)
    failed = next(each for each in judged.headlines if each.group == "failures")
    parts = [f"{failed.count} of {_counted(count, 'recording')} failed"]
    if coverage.value is None:
        parts.append("the estimates of this run state no intervals of their own")
    else:
        parts.append(
            f"of the {NOMINAL_PERCENT:.0f} % intervals that the estimates state, {coverage.count:,} of "
            f"{coverage.total:,} contain the truth ({coverage.value:.0f} %)"
        )
    if count == 1:
        return f"{'; '.join(parts)}. One recording has no spread: how it would be with another one cannot be told."
    text = "; ".join(parts) + ". Brackets hold 95 % bootstrap intervals over the recordings"
    few = f"; with only {_counted(count, 'recording')} they are wide, and a container with one recording has none"
    return f"{text}{few if count < FEW else ''}."


def tiles(judged: JudgedRun) -> Tiles:
    """The run in a few numbers against the paper."""
    groups = {name: [each for each in judged.headlines if each.group == name] for name in ("MAPE", "MPF1", "coverage")}
    failed = next(each for each in judged.headlines if each.group == "failures")
    failures = TileLine("Failed", f"{failed.count} of {failed.total}", _spread(failed))
    beside = "the paper's" if judged.is_like_with_like else "the paper's, of its own real recordings"
    return Tiles(
        [
            Tile(
                "MAPE ↓", f"Mean absolute error in % of the truth; beside it {beside}", _lines(judged, groups["MAPE"])
            ),
            Tile("MPF1 ↑", f"Mean F1-score of the classes; beside it {beside}", _lines(judged, groups["MPF1"])),
            Tile("Failures ↓", "Recordings without an estimate of their own", [failures]),
            Tile(
                f"Coverage of the {NOMINAL_PERCENT:.0f} % intervals",
                f"How often an estimate's own interval contains the truth; it should be {NOMINAL_PERCENT:.0f} %",
                [_coverage(each) for each in groups["coverage"]],
            ),
        ]
    )


def _lines(judged: JudgedRun, headlines: Sequence[Headline]) -> list[TileLine]:
    lines = []
    for each in headlines:
        paper = "" if each.reference is None else f"paper {each.reference:.1f}"
        tone: Tone = ""
        if judged.is_like_with_like and each.is_significant and each.difference is not None:
            tone = "better" if (each.difference < 0) == each.is_lower_better else "worse"
        note = "; ".join(filter(None, ["not estimated" if each.value is None else _spread(each), paper]))
        lines.append(TileLine(each.label, "–" if each.value is None else f"{each.value:.1f} %", note, tone))
    return lines


def _coverage(headline: Headline) -> TileLine:
    if headline.value is None:
        return TileLine("All", "–", "this run states no intervals")
    label = "All" if headline.name == ALL else headline.label
    note = "; ".join(filter(None, [f"{headline.count:,} of {headline.total:,}", _spread(headline)]))
    return TileLine(label, f"{headline.value:.0f} %", note, "worse" if headline.is_significant else "")


def _spread(headline: Headline) -> str:
    if headline.low is None or headline.high is None:
        return ""
    digits = 0 if headline.group in ("coverage", "failures") else 1
    unit = " %" if headline.group == "failures" else ""
    return f"95 %: {headline.low:.{digits}f}–{headline.high:.{digits}f}{unit}"


def _percent(headline: Headline) -> str:
    return f"{headline.value:.1f} %"


def _counted(count: int, what: str) -> str:
    return f"{count} {what}{'' if count == 1 else 's'}"
