"""The end of a run's report: every recording, all parameters, digests, and the commands that make it again."""

import shlex
from collections.abc import Mapping
from dataclasses import asdict, replace
from typing import Any

import pandas as pd

import corsmal
from corsmal.dataset import Dataset
from corsmal.dataset.annotation_file import listed
from corsmal.evaluation.exporting import heading
from corsmal.evaluation.metrics import CLASS_NAMES
from corsmal.figures.report import Block, Commands, Section, Table, Text
from corsmal.parameters import SELECTION_PRESETS, SHAPE_PRESETS, ShapeParameters, own_selection
from corsmal.quantities import BY_NAME, CLASSES, MEASURED
from corsmal.runs.judged import JudgedRun
from corsmal.runs.run import OWN, Run
from corsmal.weights import WeightsFile

PROGRAM = "python -m corsmal"
NO_BREAK = "\u00a0"

NAMES = {
    "circumferences": "Circumferences, L",
    "points": "Points of a circumference, N",
    "radii": "Radii tried",
    "radius_max_mm": "Largest radius, r_max (mm)",
    "radius_min_mm": "Smallest radius, r_min (mm)",
    "max_difference_mm": "Largest step between radii, d_max (mm)",
    "fit_rule": "Views that a circumference must fit",
    "width_rule": "Where widths are read",
    "height_range_reference": "Heights are measured from",
    "height_range_low_mm": "Lowest circumference (mm)",
    "height_range_high_mm": "Highest circumference (mm)",
    "tilt_deg": "Expected tilt of the axis (°)",
    "boxes": "Boxes are fitted too",
    "all_views": "The third view is used",
    "frames": "Frames fitted of a recording",
    "wall_mm": "Wall left out of the capacity (mm)",
}
"""Parameters of the fit as people read them, where the field's name does not say it."""


def recordings_table(run: Run, errors: pd.DataFrame) -> pd.DataFrame:
    """Every judged recording in words: what was estimated, and how far off that is; the worst first."""
    capacity = errors[BY_NAME["capacity_ml"].error_column].abs()
    order = pd.DataFrame({"failed": ~errors["failed"], "capacity": -capacity}).sort_values(["failed", "capacity"]).index
    estimates = run.table.set_index("recording_id").loc[order]
    own = errors.loc[order]
    columns: dict[str, Any] = {"recording": list(order), "container": own["container"].to_list()}
    columns["status"] = estimates["status"].to_list()
    columns["frame"] = ["" if pd.isna(frame) else str(frame) for frame in own["best_frame"]]
    for name in CLASSES:
        classes = zip(own[name], own[f"{name}_true"], own[f"{name}_correct"], strict=True)
        columns[heading(name)] = [_class_text(name, *each) for each in classes]
    for name in MEASURED:
        quantity = BY_NAME[name]
        numbers = zip(estimates[name], own[quantity.error_column], strict=True)
        columns[f"{quantity.label} ({quantity.unit})"] = [_number_text(*each) for each in numbers]
    return pd.DataFrame(columns)


def recordings_notes(errors: pd.DataFrame) -> list[str]:
    """What was noted of recordings, each note once, with the recordings that have it."""
    by_note: dict[str, list[str]] = {}
    for name, text in errors["notes"].items():
        for note in filter(None, str(text).split("; ")):
            by_note.setdefault(note, []).append(str(name))
    return [f"{note[:1].upper()}{note[1:]}: {listed(names)}." for note, names in by_note.items()]


def _class_text(name: str, predicted: Any, truth: Any, is_correct: Any) -> str:
    if pd.isna(predicted):
        return ""
    names = CLASS_NAMES[name]
    text = names[int(predicted)]
    return text if pd.isna(is_correct) or is_correct else f"{text}, true {names[int(truth)]}"


def _number_text(value: float, error_percent: float) -> str:
    if pd.isna(value):
        return ""
    if pd.isna(error_percent):
        return f"{value:,.0f}"
    error = f"{error_percent:+.0f} %" if abs(error_percent) >= 0.5 else "0 %"
    return f"{value:,.0f} ({error})".replace("-", "−").replace(" ", NO_BREAK)


def appendix(judged: JudgedRun, *, against: Run | None) -> Section:
    """All parameters, digests and commands."""
    run = judged.run
    own = {"This run": run.settings.shape}
    others = {} if against is None else {f"run {against.name}": against.settings.shape}
    blocks: list[Block] = [
        Text(["These commands make the numbers again; the dataset's folder is given here by its name only:"]),
        Commands(commands(judged, against=against)),
        Table(parameters_table(own | others), "Parameters of the fit"),
        Table(_facts_table(run), "What the run was made with"),
    ]
    return Section("Appendix: parameters, digests, commands", blocks, starts_page=True)


def parameters_table(shapes: Mapping[str, ShapeParameters]) -> pd.DataFrame:
    """Parameters as people read them, a column per run."""
    flat = {run: {name: _value_text(value) for name, value in _used(shape).items()} for run, shape in shapes.items()}
    names = [NAMES.get(name, heading(name)) for name in next(iter(flat.values()))]
    return pd.DataFrame({"parameter": names} | {run: list(values.values()) for run, values in flat.items()})


def _used(shape: ShapeParameters) -> dict[str, Any]:
    """The parameters of a fit, flat; ``not used`` in place of those that its method does not look at."""
    values = {name: value if name not in shape.ignored else "not used" for name, value in asdict(shape).items()}
    if "height_range" in shape.ignored:
        values["height_range"] = dict.fromkeys(asdict(shape.height_range), "not used")
    return _flat(values)


def _flat(values: Mapping[str, Any]) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for name, value in values.items():
        if isinstance(value, Mapping):
            found |= {f"{name}_{inner}": part for inner, part in value.items()}
        else:
            found[name] = value
    return found


def _value_text(value: Any) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, tuple):
        return ", ".join(map(" + ".join, value))
    return f"{value:g}" if isinstance(value, float) else str(value)


def _facts_table(run: Run) -> pd.DataFrame:
    means = run.settings.means
    facts = {
        **run.facts(),
        "means that stand in for failed fits": "none" if means is None else f"of {means.source}",
        "digest of the recordings' files": run.data_digest,
        **{f"digest of the {part} network": name for part, name in run.digests.items() if name is not None},
        "digest of the run": run.key,
        "version of the method": run.method_version,
        "version of corsmal": corsmal.__version__,
    }
    del facts["files"]
    names = [name[:1].upper() + name[1:] for name in facts]
    return pd.DataFrame({"item": names, "value": [str(value) for value in facts.values()]})


def commands(judged: JudgedRun, *, against: Run | None) -> list[str]:
    """Lines for a terminal that estimate the run again, judge it and write its report."""
    run, dataset = judged.run, judged.dataset
    options = " ".join([f"--protocol {judged.protocol}", *(f"--without {flag}" for flag in judged.without)])
    root, name = shlex.quote(dataset.name), shlex.quote(run.name)
    lines = []
    for each in (run, *([] if against is None else [against])):
        if each.preset == OWN and _preset_option(each) is None:
            lines.append(f"# {each.name}: no preset has its parameters; set them on the Shape page and start the run")
        else:
            lines.append(_estimate_command(each, dataset))
    table = shlex.quote(f"{run.name}.csv")
    lines.append(f"{PROGRAM} runs export {root} {name} {table}")
    lines.append(f"{PROGRAM} evaluate estimates {root} {table} {options}")
    beside = "" if against is None else f" --against {shlex.quote(against.name)}"
    lines.append(f"{PROGRAM} report {root} {name} {options}{beside} --out report.html")
    return lines


def _estimate_command(run: Run, dataset: Dataset) -> str:
    settings = run.settings
    ids = [] if tuple(run.recordings) == tuple(dataset.ids) else [shlex.quote(each) for each in run.recordings]
    options = [_preset_option(run) or ""]
    options += [f"--{file.kind} {_weights_option(file)}" for file in (settings.filling, settings.mass) if file]
    folders = [folder for folder in (settings.features, settings.sight) if folder is not None]
    options += [f"--features {shlex.quote(folder.name)}" for folder in folders]
    if settings.detector is not None:
        options.append(f"--detector {settings.detector.method}")
    if settings.matching.by == "index":
        options.append("--match index")
    options += [] if settings.masks == "detected" else [f"--masks {settings.masks}"]
    options += [f"--offset {view}={offset_s:g}" for view, offset_s in settings.matching.offsets_s]
    words = [PROGRAM, "estimate", shlex.quote(dataset.name), *ids, f"--run {shlex.quote(run.name)}", *options]
    return " ".join([*words, f"--out {shlex.quote(f'{run.name}.csv')}"])


def _preset_option(run: Run) -> str | None:
    """The options that give a run's parameters of the fit; None where no preset does."""
    shape = run.settings.shape
    selection = next((name for name, each in SELECTION_PRESETS.items() if each == run.settings.selection), None)
    for name, preset in SHAPE_PRESETS.items():
        if selection is not None and shape == replace(preset, wall_mm=shape.wall_mm, pairs=shape.pairs):
            options = [f"--preset {name}"]
            options += [] if shape.wall_mm == preset.wall_mm else [f"--wall {shape.wall_mm:g}"]
            options += [] if shape.pairs == preset.pairs else [f"--pairs {','.join(map('-'.join, shape.pairs))}"]
            options += [] if selection == own_selection(name) else [f"--selection {selection}"]
            return " ".join(options)
    return None


def _weights_option(file: WeightsFile) -> str:
    return "demo" if file.is_bundled else shlex.quote(file.path.name)
