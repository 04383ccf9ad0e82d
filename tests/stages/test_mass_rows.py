from dataclasses import replace

import numpy as np

from corsmal.estimation import RecordingMasks, estimate, mass_inputs
from corsmal.stages.detections import load_detections
from corsmal.stages.mass_rows import mass_rows


def with_mass(recording, mass_g):
    return replace(recording, annotation=replace(recording.annotation, container_mass_g=mass_g))


def test_rows_hold_what_the_estimate_asks_the_network(dataset, store):
    recording = with_mass(dataset["000000"], 31.0)
    steps = []
    [row] = mass_rows([recording], store=store, progress=lambda done, total: steps.append((done, total)))
    detections = load_detections(recording, store=store).views
    inputs = mass_inputs(estimate(recording, detections=detections), RecordingMasks(recording, detections))
    np.testing.assert_array_equal(row.mask, inputs.pop("mask"))
    assert {name: getattr(row, name) for name in inputs} == inputs
    assert (row.recording_id, row.mass_g, row.container) == ("000000", 31.0, recording.annotation.container)
    assert steps == [(1, 1)]


def test_recordings_without_an_annotated_mass_are_left_out(dataset, store):
    unknown = [with_mass(dataset["000000"], None), replace(dataset["000000"], annotation=None)]
    assert list(mass_rows(unknown, store=store)) == []


def test_recording_that_cannot_be_fitted_is_a_row_without_measures(dataset, store):
    [row] = mass_rows([replace(with_mass(dataset["000000"], 31.0), views={})], store=store)
    assert not row.mask.any()
    assert (row.width_top_mm, row.width_bottom_mm, row.height_mm, row.mm_per_px) == (None,) * 4
