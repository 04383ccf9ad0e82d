"""Browse the dataset: a table of all recordings, and the chosen one's videos and sound."""

import streamlit as st

from corsmal.digests import digest
from corsmal.ui import media, session, shared
from corsmal.ui.choice import OF_RECORDING
from corsmal.ui.detecting import watch_detection
from corsmal.ui.filling import sound
from corsmal.ui.filling.microphone import microphone_control
from corsmal.ui.findings import show_findings, show_recordings_findings
from corsmal.ui.messages import guarded
from corsmal.ui.opened import OpenedRecording
from corsmal.ui.recordings import COLUMNS, all_recordings, filter_controls, listed, newly_clicked
from corsmal.ui.routes import thumbnail_urls

TITLES = {"view1": "left of the robot", "view3": "frontal", "view2": "right of the robot", "view4": "worn"}

st.title("Recordings")
dataset, recording = session.opened()
shown = all_recordings(dataset)
filter_controls(shown)
rows = listed(dataset)
st.caption(f"{len(rows)} of {len(shown)} recordings. Click a row to open it, step with `[` and `]`.")
rows.insert(0, "picture", thumbnail_urls(dataset, list(rows.index)))
key = f"recordings {digest('recordings', str(dataset.root), list(rows.index))}"
event = st.dataframe(
    rows,
    key=key,
    on_select="rerun",
    selection_mode=["single-row", "single-cell"],
    row_height=56,
    height=min(340, 38 + 56 * max(1, len(rows))),
    column_config=COLUMNS,
)
clicked = newly_clicked(event.selection, key=key)
if clicked is not None and rows.index[clicked] != recording.id:
    session.choose(recording=rows.index[clicked], **OF_RECORDING)
    st.rerun()

show_findings(dataset)

st.subheader(f"Recording {recording.id}")
opened = OpenedRecording(recording)
watch_detection(opened)
if recording.missing:
    st.warning(f"Missing: {', '.join(recording.missing)}.", icon=":material/inventory_2:")
show_recordings_findings(dataset, recording)
names = [name for name in TITLES if name in recording.views]
for column, name in zip(st.columns(max(1, len(names))), names, strict=False):
    with column, guarded():
        st.markdown(f"**{name}** · {TITLES[name]}")
        st.video(media.playable_video(recording.views[name], store=shared.store()), loop=True, muted=True)
if recording.audio_path is not None:
    with guarded():
        left, right = st.columns([1, 3], vertical_alignment="bottom")
        channel = microphone_control(left, "Microphone")
        right.audio(sound.wav(opened, channel, None))
