"""Everything about the chosen recording on one page: the answers, what they come from, and what was known when."""

import streamlit as st

from corsmal.stages.settings import left_out_note
from corsmal.ui import session, sidebar
from corsmal.ui.detecting import detection_control, is_detecting
from corsmal.ui.drawing import let_draw
from corsmal.ui.estimating import (
    estimate_control,
    estimate_settings,
    kept_numbers,
    let_draw_before_networks,
    predictors,
    whole_estimate,
)
from corsmal.ui.look import heading
from corsmal.ui.messages import guarded
from corsmal.ui.opened import OpenedRecording
from corsmal.ui.overview import known_when, pictures
from corsmal.ui.overview.numbers import network_tiles, shape_tiles
from corsmal.ui.overview.status import computing, left_out, summary
from corsmal.ui.overview.tiles import Tiles
from corsmal.ui.pins import pin_button

dataset, recording = session.opened()
opened = OpenedRecording(recording, session.choice().selected_by)
with heading("Overview"):
    estimate_control()
status = st.empty()
detection_control(opened)  # first: what is found from here on makes the page run again
is_inspected = bool(opened.detections.views)
session.keep_frame_within(opened.frames)
tiles = Tiles()
note = st.empty()

with guarded():
    settings = estimate_settings(dataset)
    known = kept_numbers(opened, settings)
    if known is None:
        status.caption(computing("shape", "filling", "mass"))
        tiles.show_pending()
        sidebar.show()
    found = opened.estimate(settings.shape, settings.means)
    reasons, numbers = left_out(settings), shape_tiles(found, recording.annotation, is_inspected=is_inspected)
    if known is not None:  # the numbers come from a run, and need not wait for the networks to be read
        numbers += network_tiles(known, recording.annotation, left_out=reasons)
    tiles.show(numbers, found)
    if known is not None:
        let_draw("numbers")
        sidebar.show()
    pictures.views(opened, found)
    hull, mask, sound = st.columns([4, 3, 3], gap="medium")
    with hull:
        pictures.hull(opened, found)

    status.caption(computing("logits" if known is not None else "filling and mass"))
    if known is not None:
        let_draw_before_networks()
    found, row = whole_estimate(opened, settings)
    if known is None:
        tiles.show(network_tiles(row, recording.annotation, left_out=reasons), found)
    with mask:
        pictures.mask(opened, found)
    with sound:
        pictures.heard(opened, found, left_out=reasons.get("filling", ""))
    pin_button("the answers", lambda: pictures.answer_pins(opened, found, tiles.shown), key="overview")
    if text := left_out_note(dataset, settings):
        note.caption(f":material/info: {text}")

    st.subheader("What was known when")
    networks = predictors(settings)
    job = None if is_detecting(opened) else known_when.begin(opened, networks)
    status.caption(summary(opened, found, job=job))
    known_when.panel(opened, networks, found, job)
