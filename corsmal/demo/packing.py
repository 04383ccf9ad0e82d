"""Making the ready-made demo anew, after a change of the renderer, the networks or the method."""

import json
import shutil
import time
from collections import deque
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from corsmal.dataset import Dataset, open_dataset
from corsmal.demo.opening import FOLDER, MARK, PACK, made_when, set_times, with_networks_in
from corsmal.errors import ArgumentError
from corsmal.parameters import SHAPE_PRESETS
from corsmal.runs.attribution import attribute_run
from corsmal.runs.making import make_run
from corsmal.runs.rules import comparable, compare_rules
from corsmal.runs.run import Run, save_run
from corsmal.stages.detections import POINTERS, load_detections
from corsmal.stages.estimates import Predictors
from corsmal.stages.fits import load_fit
from corsmal.stages.moments import kept_estimate, known_when, moments_s
from corsmal.stages.search import detect_recording
from corsmal.stages.settings import EstimateSettings, default_settings, find_detector
from corsmal.store import Store
from corsmal.synthetic import write_demo
from corsmal.weights import WeightsFile, bundled_path

IDS = ("000000", "000003", "000005", "000009", "000012", "000013")
"""The recordings, out of the full demo's thirty; the pack's README says what each shows."""

PRESETS = ("paper", "tuned")
"""Of the fit; there is a run of each."""

APART = "moments"
"""The store for what was known when, beneath the other one: its hulls are ten times as many, and no page shows them."""

KINDS = ("detections", *POINTERS, "estimates", "fits", "attributions", "rules", f"{APART}/known-when")
"""What is packed of the stores; log-mel rows are as large as the sound, and computed in half a second."""

BYTES_MAX = 12_500_000


def make_pack(work: Path, *, pack: Path = PACK, say: Callable[[str], object]) -> None:
    """Make recordings, detections, fits and runs, and put them in the place of the earlier ones.

    Args:
        work: a new folder; what an interrupted call left in it is not made again.
        pack: the pack's folder; its README stays.
        say: is told each step.

    Raises:
        ArgumentError: the pack would be too large.
        CorsmalError: a stage failed.
    """
    from corsmal.detection import SmallDetector  # noqa: PLC0415 - loads PyTorch

    root, store = work / FOLDER, Store(work)
    say("Rendering")
    write_demo(root, ids=IDS, compact=True)
    mark = root / MARK
    if not mark.is_file():
        mark.write_text(json.dumps({"made_ns": int(time.time()) * 10**9}), encoding="utf-8")
    made_ns = made_when(mark)
    set_times(root, made_ns)
    dataset = open_dataset(root)
    detector = SmallDetector(bundled_path("detector"))
    for recording in dataset:
        say(f"Detecting in {recording.id}")
        detect_recording(recording, detector, store=store)
    set_times(work, made_ns)  # the keys of what follows hold the times of the files of detections
    runs = []
    for preset in PRESETS:
        say(f"Estimating with {preset}")
        settings = packed_settings(dataset, preset)
        runs.append(make_run(preset, dataset, settings, store=store))
        _keep_what_pages_show(dataset, settings, store=store)
        attribute_run(runs[-1], dataset, store=store)
    say("Comparing the rules")
    compare_rules(comparable(dataset, store=store), store=store)
    say("Copying")
    _replace(pack, root, store, runs)


def packed_settings(dataset: Dataset, preset: str) -> EstimateSettings:
    """What a run of the pack is made with: the bundled networks, whatever the environment names."""
    settings = default_settings(dataset, shape=SHAPE_PRESETS[preset], filling="demo", mass="demo")
    return replace(
        settings,
        filling=WeightsFile("filling", bundled_path("filling"), "bundled"),
        mass=WeightsFile("mass", bundled_path("mass"), "bundled"),
        detector=find_detector("demo", weights=bundled_path("detector")),
    )


def _keep_what_pages_show(dataset: Dataset, settings: EstimateSettings, *, store: Store) -> None:
    """Keep the hulls that the estimates are made of and the one that is shown first, and what was known when."""
    predictors, apart = settings.open(), Store(store.root / APART)
    for recording in dataset:
        detections = load_detections(recording, store=store)
        kept_estimate(recording, detections, predictors, store=store)
        first = kept_estimate(recording, detections, Predictors(), store=store).best_frame
        if first is not None and first.frame is not None:
            load_fit(
                recording,
                detections,
                pair=first.pair,
                frame=first.frame,
                centre_rule=first.centre_rule,
                shape=settings.shape,
                store=store,
            )
        deque(known_when(recording, detections, predictors, moments_s(recording), store=apart), maxlen=0)


def _replace(pack: Path, root: Path, store: Store, runs: list[Run]) -> None:
    """Put the dataset and the results in place of the earlier ones; no file names this machine's folders."""
    sources = {"recordings": root, **{f"results/{Path(kind).name}": store.root / kind for kind in KINDS}}
    size = sum(path.stat().st_size for folder in sources.values() for path in folder.rglob("*") if path.is_file())
    if size > BYTES_MAX:
        raise ArgumentError(f"IDS must name recordings that take {BYTES_MAX} bytes at most, got {size}")
    for name in ("recordings", "results"):
        shutil.rmtree(pack / name, ignore_errors=True)
    for name, source in sources.items():
        shutil.copytree(source, pack / name)
    for run in runs:
        save_run(replace(with_networks_in(run, Path()), dataset=FOLDER), store=Store(pack / "results"))
