import json

import numpy as np
import pandas as pd

from corsmal.dataset.clock import Matching
from corsmal.mass import MassRow
from corsmal.runs.records import record_json, record_of
from corsmal.runs.reproduction_files import _settings_words
from corsmal.runs.reproduction_notes import filling_notes, mass_notes
from corsmal.runs.reproduction_settings import ReproductionSettings


def known(types, levels):
    return pd.DataFrame({"filling_type": types, "filling_level": levels})


def test_a_single_class_is_said():
    notes = filling_notes(known([1, 1, 1], [1, 2, 1]), pd.Series([0, 1, 2]))
    assert notes[0] == "All 3 recordings have the filling type pasta: its scores say nothing."


def test_a_class_that_a_fold_s_network_was_not_shown_is_said():
    notes = filling_notes(known([0, 1, 3, 0, 1, 3], [0, 1, 2, 0, 1, 1]), pd.Series([0, 0, 0, 1, 1, 0]))
    assert len(notes) == 2
    assert notes[0].startswith("The filling type water is in fold 0 only")
    assert notes[1].startswith("The filling level full is in fold 0 only")


def test_nothing_is_said_where_every_fold_is_taught_every_class():
    assert filling_notes(known([0, 1, 0, 1], [0, 1, 0, 1]), pd.Series([0, 0, 1, 1])) == []


def test_containers_too_few_for_a_validation_part_are_said():
    sizes = {"width_top_mm": 90.0, "width_bottom_mm": 60.0, "height_mm": 120.0, "mm_per_px": None, "mass_g": 10.0}
    rows = [
        MassRow(f"{index:06d}", container, np.ones((2, 2), bool), **sizes)
        for index, container in enumerate(["red cup"] * 3 + ["wine glass"] * 2)
    ]
    assert mass_notes(rows[:3], share=0.2) == []
    assert [note.split(":")[0] for note in mass_notes(rows, share=0.2)] == ["Container wine glass"]


def test_how_views_are_matched_is_kept_and_told():
    settings = ReproductionSettings(matching=Matching(offsets_s=(("view2", 0.2),)))
    kept = json.loads(json.dumps(record_json(settings)))
    assert record_of(ReproductionSettings, kept) == settings
    assert _settings_words(settings)["Views matched"] == "by time, view2 +0.2 s"
    del kept["matching"]
    assert record_of(ReproductionSettings, kept).matching == Matching()
