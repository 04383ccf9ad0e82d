"""The pack is what the renderer, the detector and the method make today: parts of it are made anew and compared."""

import json
from functools import cache

import numpy as np
import pytest

from corsmal.dataset import open_dataset
from corsmal.dataset.calibration import read_camera
from corsmal.dataset.truth import true_mask_path
from corsmal.demo.opening import PACK, open_demo
from corsmal.demo.packing import BYTES_MAX, IDS, PRESETS, packed_settings
from corsmal.detection import SmallDetector
from corsmal.parameters import METHOD_VIEWS
from corsmal.quantities import GEOMETRY, QUANTITIES
from corsmal.runs import load_run
from corsmal.runs.attribution import STAGES, AttributionTask, load_attribution
from corsmal.runs.rules import compare_rules, load_rules
from corsmal.stages.detections import load_detections
from corsmal.stages.estimates import load_estimate
from corsmal.stages.true_masks import true_masks
from corsmal.store import Store
from corsmal.synthetic.render.frame import render_frame
from corsmal.synthetic.scene.cameras import DEMO_SIZE
from corsmal.synthetic.scene.scene import sound_events
from corsmal.synthetic.sound.recording import recording_sound
from corsmal.synthetic.writing.parts import ANNOTATION_FILE
from corsmal.synthetic.writing.plan import annotation_of, plan_recordings
from corsmal.synthetic.writing.recording import scene_truth
from corsmal.weights import bundled_path

ADVICE = "make the pack anew, as CONTRIBUTING.md says"
BIT = 2.0**-15
FRAMES = (0.0, 0.45, 0.7)
"""Of a recording, the frames that are drawn anew: at the start, while something is poured or shaken, and later."""
PLAN = {planned.recording_id: planned for planned in plan_recordings() if planned.recording_id in IDS}


@cache
def scene_of(name):
    return PLAN[name].scene()


@pytest.fixture(scope="module")
def store(tmp_path_factory):
    return Store(tmp_path_factory.mktemp("cache"))


@pytest.fixture(scope="module")
def dataset(store):
    return open_dataset(open_demo(store=store))


@pytest.fixture(scope="module")
def detector():
    return SmallDetector(bundled_path("detector"), device="cpu")


def frames_of(name):
    return [round(share * (scene_of(name).frames - 1)) for share in FRAMES]


def iou(first, second):
    union = (first | second).sum()
    return 1.0 if not union else (first & second).sum() / union


def test_it_is_small_enough():
    assert sum(path.stat().st_size for path in PACK.rglob("*") if path.is_file()) <= BYTES_MAX


def test_it_has_what_its_readme_promises():
    scenes = [scene_of(name) for name in IDS]
    assert {scene.container.kind for scene in scenes} == {"cup", "glass", "box"}
    assert {scene.filling_level for scene in scenes} == {0, 1, 2}
    assert {scene.timing.action for scene in scenes} >= {"pour", "shake"}
    assert {scene.container.container_id < 10 for scene in scenes} == {True, False}
    text = (PACK / "README.md").read_text(encoding="utf-8")
    for name, scene in zip(IDS, scenes, strict=True):
        assert f"| {name} | {scene.container.name} |" in text


def test_annotation_truth_and_calibrations_are_the_scenes(dataset):
    found = json.loads((dataset.root / ANNOTATION_FILE).read_text(encoding="utf-8"))
    expected = annotation_of([PLAN[name].annotation() for name in IDS])
    assert found == json.loads(json.dumps(expected)), ADVICE
    for recording in dataset:
        scene = scene_of(recording.id)
        assert nine_digits(recording.truth_path.read_text(encoding="utf-8")) == nine_digits(
            json.dumps(scene_truth(scene))
        ), ADVICE
        for view in METHOD_VIEWS:
            found_m = read_camera(recording.views[view].calibration_path).projection
            np.testing.assert_allclose(found_m, scene.cameras[view].projection, rtol=1e-9, atol=1e-9, err_msg=ADVICE)


def nine_digits(text):
    """What JSON says, without the last digits, in which processors differ."""
    return json.loads(text, parse_float=lambda number: float(f"{float(number):.9g}"))


@pytest.mark.parametrize("name", IDS)
def test_the_sound_is_the_scenes(dataset, name):
    scene, audio = scene_of(name), dataset[name].audio()
    expected = recording_sound(sound_events(scene), rng=np.random.default_rng([scene.seed, 3]))
    assert audio.samples.shape == expected.shape, ADVICE
    np.testing.assert_allclose(audio.samples, expected, atol=2 * BIT, err_msg=ADVICE)


@pytest.mark.parametrize("name", IDS)
def test_frames_and_masks_are_the_renderers_and_detections_the_detectors(dataset, store, detector, name):
    recording, scene = dataset[name], scene_of(name)
    kept = load_detections(recording, store=store).views
    for view in METHOD_VIEWS:
        masks = {kind: true_masks(recording, view, kind=kind) for kind in ("visible", "amodal")}
        assert true_mask_path(recording, view, kind="visible").is_file()
        with recording.views[view].video() as video:
            assert (len(video), video.size) == (scene.frames, DEMO_SIZE), ADVICE
            assert kept[view].frames == tuple(range(scene.frames)), ADVICE
            images = [video[frame] for frame in frames_of(name)]
        for frame, image, found in zip(frames_of(name), images, detector.detect(images), strict=True):
            drawn = render_frame(scene, view, frame, size=DEMO_SIZE)
            difference = np.abs(image.astype(float) - drawn.image)
            assert difference.mean() < 4, ADVICE
            assert np.quantile(difference, 0.99) < 30, ADVICE
            for kind, expected in (("visible", drawn.visible), ("amodal", drawn.amodal)):
                true = masks[kind][frame].masks.any(axis=0)
                assert iou(true, expected) > 0.99, ADVICE
            expected = kept[view][frame]
            assert found.labels.tolist() == expected.labels.tolist(), ADVICE
            np.testing.assert_allclose(found.scores, expected.scores, atol=0.02, err_msg=ADVICE)
            np.testing.assert_allclose(found.boxes, expected.boxes, atol=1.0, err_msg=ADVICE)
            for first, second in zip(found.masks, expected.masks, strict=True):
                assert iou(first, second) > 0.97, ADVICE


@pytest.mark.parametrize("preset", PRESETS)
def test_the_rows_are_those_of_todays_method_and_networks(dataset, store, tmp_path, preset):
    run = load_run(preset, dataset=dataset.root, store=store)
    predictors = packed_settings(dataset, preset).open()
    assert run.settings == packed_settings(dataset, preset), ADVICE
    assert {name: run.digests[name] for name in ("filling", "mass")} == predictors.digests, ADVICE
    empty = Store(tmp_path)
    for kind in ("detections", "latest"):
        (tmp_path / kind).symlink_to(store.root / kind)
    for kept in run.rows[:: len(IDS) // 2]:
        row = load_estimate(dataset[kept["recording_id"]], predictors, store=empty)
        for quantity in QUANTITIES:
            expected = kept[quantity.name]
            assert row[quantity.name] == (expected and pytest.approx(expected, rel=1e-3)), ADVICE


@pytest.mark.parametrize("preset", PRESETS)
def test_the_readme_has_the_errors_of_the_runs(dataset, store, preset):
    run = load_run(preset, dataset=dataset.root, store=store)
    lines = [line.split("|") for line in (PACK / "README.md").read_text(encoding="utf-8").splitlines()]
    written = {line[1].strip(): line[5 + PRESETS.index(preset)].split() for line in lines if len(line) > 6}
    for row in run.rows:
        truth = dataset[row["recording_id"]].annotation
        quantities = (*GEOMETRY, "container_mass_g")
        errors = [round(100 * (row[name] / getattr(truth, name) - 1)) for name in quantities]
        found = [int(number.replace("−", "-")) for number in written[row["recording_id"]]]
        assert found == errors, "write the errors of the runs into the pack's README"


@pytest.mark.parametrize("preset", PRESETS)
def test_the_attribution_is_kept_and_that_of_todays_method(dataset, store, tmp_path, preset):
    run = load_run(preset, dataset=dataset.root, store=store)
    kept = load_attribution(run, dataset, store=store)
    assert kept is not None, ADVICE
    assert tuple(kept) == STAGES, ADVICE
    assert all([row["recording_id"] for row in rows] == list(IDS) for rows in kept.values()), ADVICE
    for kind in ("detections", "latest"):
        (tmp_path / kind).symlink_to(store.root / kind)
    made = AttributionTask(tmp_path, run.settings, STAGES)(dataset[IDS[1]])["rows"]
    for stage in STAGES:
        assert_same_geometry(made[stage], kept[stage][1])


def test_the_comparison_of_the_rules_is_kept_and_that_of_todays_method(dataset, store, tmp_path):
    kept = load_rules(dataset, store=store)
    assert kept is not None, ADVICE
    for kind in ("detections", "latest"):
        (tmp_path / kind).symlink_to(store.root / kind)
    made = compare_rules([dataset[IDS[1]]], store=Store(tmp_path))
    for condition, rows in kept.items():
        assert_same_geometry(made[condition][0], rows[1])


def assert_same_geometry(row, kept):
    for name in GEOMETRY:
        assert row.get(name) == (kept.get(name) and pytest.approx(kept[name], rel=1e-3)), ADVICE
