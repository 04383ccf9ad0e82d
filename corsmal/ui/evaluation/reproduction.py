"""The paper's evaluation repeated on the dataset, as ``python -m corsmal reproduce`` does, and its results."""

from collections.abc import Mapping
from pathlib import Path

import pandas as pd
import streamlit as st

from corsmal.dataset import Dataset
from corsmal.dataset.annotation import Kind
from corsmal.digests import digest
from corsmal.evaluation.typesetting import TITLES
from corsmal.figures.heatmaps import confusion_figure
from corsmal.runs.reproduction_kept import (
    ESTIMATES,
    REPORT,
    SUMMARY,
    KeptReproduction,
    kept_reproductions,
    read_reproduction,
)
from corsmal.runs.reproduction_settings import features_text
from corsmal.ui import shared
from corsmal.ui.caching import cached
from corsmal.ui.download_buttons import download_buttons
from corsmal.ui.evaluation.downloads import notes
from corsmal.ui.evaluation.errors import CLASSES
from corsmal.ui.evaluation.judged import Judged, has_truth
from corsmal.ui.evaluation.leaderboard import scores_table
from corsmal.ui.evaluation.new_reproduction import job_key, new_reproduction
from corsmal.ui.evaluation.tables import container_section
from corsmal.ui.folders import READ_ONLY, data_root, is_read_only
from corsmal.ui.following import follow
from corsmal.ui.linked_plot import linked_plot
from corsmal.ui.messages import guarded, plain
from corsmal.ui.one_of import one_of

OWN_TEAM = "this program"


def reproduction_section(dataset: Dataset) -> None:
    """What is kept in the output folder, and a form for more."""
    if not has_truth(dataset):
        return
    out = _output_folder(dataset)
    key = job_key(out)
    is_running = follow(key, unit="%")
    kept = kept_reproductions(out)
    if shared.jobs().state(key) == "cancelled":
        st.info(
            "The reproduction was stopped. What was done is kept: started again with the same settings, it resumes.",
            icon=":material/pause_circle:",
        )
    if is_read_only():
        st.caption(f":material/lock: {READ_ONLY}")
    else:
        with st.expander("New reproduction", expanded=not (kept or is_running), icon=":material/add:"):
            new_reproduction(dataset, out, is_running=is_running)
    chosen = _chosen(kept)
    if chosen is not None:
        with guarded():
            _show(chosen, dataset)


def _output_folder(dataset: Dataset) -> Path:
    """The folder of networks, tables and report; one that the command line wrote shows its results here."""
    own = f"{dataset.name}-{digest('dataset', str(dataset.root))[:8]}"
    usual = shared.store().root.resolve() / "reproductions" / own
    if is_read_only() or data_root() is not None:  # visitors name no folder to be written to
        return usual
    text = st.text_input(
        "Output folder",
        str(usual),
        key=f"reproduction_out {own}",
        help="For networks, tables and the report. With the folder of `python -m corsmal reproduce ROOT --out`, its "
        "results are shown below, and an interrupted command is resumed.",
    )
    return Path(text.strip() or ".").expanduser().resolve()


def _chosen(kept: list[Path]) -> KeptReproduction | None:
    """One of those that are kept, at first the newest; what cannot be read is reported."""
    found: dict[str, KeptReproduction] = {}
    for folder in kept:
        with guarded():
            found[folder.name] = _read(folder, (folder / SUMMARY).stat().st_mtime_ns)
    if not found:
        return None
    labels = {name: _label(each) for name, each in found.items()}
    return found[one_of("Results", labels, key=f"reproduction {kept[0]} {len(kept)}")]


@cached(8, key=lambda folder, time_ns: (folder, time_ns))
def _read(folder: Path, time_ns: int) -> KeptReproduction:
    del time_ns
    return read_reproduction(folder)


def _label(kept: KeptReproduction) -> str:
    settings = kept.settings
    return f"{TITLES[settings.protocol]}, {settings.folds}{', quick' * settings.is_quick}, {kept.made:%Y-%m-%d %H:%M}"


def _show(kept: KeptReproduction, dataset: Dataset) -> None:
    settings = kept.settings
    facts = {
        "seeds": settings.seeds,
        "networks": settings.networks,
        "parameters of the fit": kept.run.preset,
        "features": features_text(settings),
        "detector": "none" if settings.detector is None else settings.detector.method,
        "views matched": settings.matching,
    }
    st.caption(f":material/tune: {plain(' · '.join(f'{name}: {value}' for name, value in facts.items()))}")
    if settings.is_quick:
        st.warning("Trained for a few epochs only (quick): a first look, not a result.", icon=":material/warning:")
    notes(kept.notes)
    _files(kept)
    st.subheader("Table 2")
    container_section(Judged(kept.run, dataset, settings.protocol))
    st.subheader("Fig. 3")
    if settings.protocol == "paper":
        st.caption("Of the round whose kept epoch has the least loss, as published.")
    for quantity, tables in kept.confusions.items():
        _confusions(quantity, {kind: table for kind, table in tables.items() if table.to_numpy().any()})
    for test, table in kept.scores.items():
        st.subheader(f"Table 3: test set {plain(test)}")
        if "note" in table:
            st.caption(plain(table["note"].iloc[0]))
        else:
            scores_table(table, key=f"scores {kept.folder} {test}", own=OWN_TEAM)


def _files(kept: KeptReproduction) -> None:
    files = {"Report (HTML)": REPORT, "Estimates (CSV)": ESTIMATES}
    files |= {f"Submission {test} (CSV)": f"submission_{test}.csv" for test in kept.scores}
    files |= {f"Table 2 ({name})": f"table2.{ending}" for name, ending in (("CSV", "csv"), ("LaTeX", "tex"))}
    download_buttons({label: (name, (kept.folder / name).read_bytes) for label, name in files.items()})


def _confusions(quantity: str, tables: Mapping[Kind, pd.DataFrame]) -> None:
    if not tables:
        st.caption(f"{CLASSES[quantity]}: nothing was predicted.")
        return
    st.markdown(f"**{CLASSES[quantity]}**: rows are true, columns predicted")
    linked_plot(
        confusion_figure(tables),
        key=f"fig3_{quantity}",
        label=f"Fig. 3: confusion of {CLASSES[quantity].lower()} by kind of container",
        height_px=360,
    )
