"""What the pages say about the network that predicts."""

import streamlit as st

from corsmal.ui.messages import plain
from corsmal.weights import RELEASED, Kind, find_weights, network_digest


def network_note(kind: Kind) -> None:
    """Say which network predicts where it is not the bundled one, and what is known about its training."""
    file = find_weights(kind)
    if file.is_bundled or not file.path.is_file():
        return
    digest = network_digest(kind, file.path)
    text = f"Network: {file.path.name} ({digest.rsplit(maxsplit=1)[-1][:8]})."
    if digest.startswith(RELEASED):
        text += (
            " It has the form of the authors' program. The file does not say what it was trained on; the authors' own "
            "networks saw the published training set, so no answer to a recording of that set is held out."
        )
    st.caption(f":material/neurology: {plain(text)}")
