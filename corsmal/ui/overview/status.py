"""What the numbers are from, and what is still missing."""

from corsmal.estimation import Estimate
from corsmal.stages.settings import EstimateSettings
from corsmal.ui import session
from corsmal.ui.job import Job
from corsmal.ui.messages import plain
from corsmal.ui.opened import OpenedRecording
from corsmal.weights import find_weights

COMPUTING = ":material/hourglass_top: Being computed: "


def computing(*parts: str) -> str:
    """What is being computed."""
    return f"{COMPUTING}{', '.join(parts)} …"


def summary(opened: OpenedRecording, found: Estimate, *, job: Job | None) -> str:
    """What the numbers are from, once they are there."""
    sources = sorted({view.source for view in opened.detections.views.values()})
    facts = [
        f"preset `{session.choice().estimate_name}`",
        found.status if found.fit is not None else "nothing was fitted",
    ]
    if sources:
        inspected = max(len(view) for view in opened.detections.views.values())
        facts.append(f"{inspected} of {opened.frames} frames inspected by {plain('; '.join(sources))}")
    if job is not None and job.active:
        return f"{computing('what was known when')} The numbers: {' · '.join(facts)}"
    return f":material/check_circle: {' · '.join(facts)}"


def left_out(settings: EstimateSettings) -> dict[str, str]:
    """Why a network is left out, by ``filling`` and ``mass``."""
    reasons = {}
    for kind, file in (("filling", settings.filling), ("mass", settings.mass)):
        if file is None:
            there = find_weights("filling" if kind == "filling" else "mass").path.is_file()
            reasons[kind] = (
                "the bundled network was trained on synthetic recordings only" if there else "its weights are missing"
            )
    return reasons
