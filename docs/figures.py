"""The figures of docs/method.md, drawn by the library from the demo: ``.venv/bin/python docs/figures.py``."""

from pathlib import Path

from corsmal.dataset import open_dataset
from corsmal.demo.opening import open_demo
from corsmal.estimation import RecordingMasks, mass_inputs
from corsmal.estimation import estimate as estimate_recording
from corsmal.evaluation import error_table
from corsmal.figures import export_figure, hull_figure, profile_figure, reprojection_figure, score_figure
from corsmal.figures.restoration import restoration_figure
from corsmal.mass import MassPredictor
from corsmal.parameters import FRONTAL_VIEW, PAIRS, ShapeParameters
from corsmal.quantities import BY_NAME, MEASURED
from corsmal.runs import list_runs
from corsmal.selection import select_best_frame
from corsmal.stages.detections import load_detections
from corsmal.store import Store
from corsmal.weights import bundled_path

PICTURES = Path(__file__).parent / "pictures"
RECORDING = "000000"
WIDE_PX, NARROW_PX, LOW_PX = 1200, 640, 400


def main() -> None:
    """Write all of them."""
    store, shape = Store(), ShapeParameters.paper()
    dataset = open_dataset(open_demo(store=store))
    recording = dataset[RECORDING]
    detections = load_detections(recording, store=store).views
    found = estimate_recording(recording, detections=detections, shape=shape)
    if found.fit is None or found.fit.frame is None or found.best_frame is None:
        raise SystemExit(f"{RECORDING} was not fitted: {found.notes}")
    fit, frame, rule = found.fit, found.fit.frame, found.best_frame.centre_rule
    masks = RecordingMasks(recording, detections)
    image = recording.video(FRONTAL_VIEW)[frame]

    best = select_best_frame(detections, pair=PAIRS[0])
    export_figure(score_figure(best).update_layout(height=LOW_PX), PICTURES / "scores.png", width_px=WIDE_PX)
    cameras = {name: recording.views[name].camera() for name in fit.pair}
    export_figure(hull_figure(fit.hull, fit.dimensions, cameras=cameras), PICTURES / "hull.png", width_px=NARROW_PX)
    over = reprojection_figure(
        image, masks.mask(FRONTAL_VIEW, frame, rule), masks.camera(FRONTAL_VIEW), fit.hull, parameters=shape
    )
    export_figure(over, PICTURES / "reprojection.png", width_px=NARROW_PX)
    export_figure(profile_figure(fit.hull, fit.dimensions), PICTURES / "profile.png", width_px=NARROW_PX)

    predictor, inputs = MassPredictor(bundled_path("mass")), mass_inputs(found, masks)
    if inputs is not None:
        said = predictor.predict(**inputs)
        if said.network_input is not None:
            panels = restoration_figure(
                image, inputs["mask"], said.restored, network_input=said.network_input, resize=predictor.config.resize
            )
            panels.update_layout(height=LOW_PX)
            export_figure(panels, PICTURES / "restoration.png", width_px=WIDE_PX)
    (PICTURES / "tuned.md").write_text(presets_table(store), encoding="utf-8")


def presets_table(store: Store) -> str:
    """Mean absolute errors of the demo's two runs, as a Markdown table."""
    dataset = open_dataset(open_demo(store=store))
    runs = {run.name: run for run in list_runs(store=store, dataset=dataset.root)}
    rows = ["| | `paper` | `tuned` |", "|---|---|---|"]
    tables = {name: error_table(runs[name].table, dataset.table, protocol="in-sample") for name in ("paper", "tuned")}
    for name in MEASURED:
        quantity = BY_NAME[name]
        errors = [table[quantity.error_column].abs().mean() for table in tables.values()]
        rows.append(f"| {quantity.words.capitalize()} | " + " | ".join(f"{error:.0f}" for error in errors) + " |")
    return "\n".join(rows) + "\n"


if __name__ == "__main__":
    main()
