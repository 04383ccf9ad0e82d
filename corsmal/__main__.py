"""The command line: ``corsmal --help``, or ``python -m corsmal --help`` where the package is not installed."""

import errno
import sys
from collections.abc import Callable, Mapping

import typer

from corsmal.commands import (
    complain,
    complaints_of_the_store,
    detector,
    evaluating,
    exporting,
    filling,
    keeping_runs,
    masks,
    mass,
    runs,
)
from corsmal.commands.app import app as start_app
from corsmal.commands.attribution import attribute
from corsmal.commands.comparing import compare
from corsmal.commands.demo import demo
from corsmal.commands.doctor import doctor
from corsmal.commands.features import features
from corsmal.commands.reporting import report
from corsmal.commands.reproducing import reproduce
from corsmal.errors import CorsmalError
from corsmal.installation import missing_extra

Command = Callable[..., None]

FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
"""The errors of a disk that has no room, or not for this user or file."""

COMMANDS: dict[str, Command] = {
    "app": start_app,
    "demo": demo,
    "detect": detector.detect,
    "features": features,
    "estimate": runs.estimate,
    "submit": runs.submit,
    "report": report,
    "attribute": attribute,
    "reproduce": reproduce,
    "doctor": doctor,
}
RUNS: dict[str, Command] = {
    "list": runs.list_runs,
    "show": runs.show,
    "compare": keeping_runs.compare,
    "export": runs.export,
    "rename": keeping_runs.rename,
    "note": keeping_runs.note,
    "archive": keeping_runs.archive,
    "delete": runs.delete,
    "restore": keeping_runs.restore,
}
TRAIN: dict[str, Command] = {
    "filling": filling.train,
    "mass": mass.train,
    "wall": evaluating.wall,
    "detector": detector.train,
}
EXPORT: dict[str, Command] = {
    "detections": exporting.detections,
    "rerun": exporting.rerun,
}
MASKS: dict[str, Command] = {
    "show": masks.show,
    "next": masks.following,
    "export": masks.export,
    "import": masks.read,
}
EVALUATE: dict[str, Command] = {
    "estimates": evaluating.estimates,
    "filling": filling.evaluate,
    "mass": mass.evaluate,
    "detector": detector.evaluate,
    "compare": compare,
}


def command_group(commands: Mapping[str, Command], *, what: str, add_completion: bool = False) -> typer.Typer:
    """The commands of a group by name, in the order of their help."""
    group = typer.Typer(no_args_is_help=True, add_completion=add_completion, pretty_exceptions_enable=False, help=what)
    for name, command in commands.items():
        group.command(name)(command)
    return group


WHAT = "Estimate capacity, dimensions, filling and mass of containers from recordings."

app = command_group(COMMANDS, what=WHAT, add_completion=True)
app.add_typer(command_group(RUNS, what="List, show, compare, export, rename and delete runs."), name="runs")
app.add_typer(command_group(EXPORT, what="Write results of a recording for other programs."), name="export")
app.add_typer(command_group(MASKS, what="Masks by hand of a recording."), name="masks")
app.add_typer(command_group(TRAIN, what="Train a network, or learn the wall thickness of containers."), name="train")
app.add_typer(command_group(EVALUATE, what="Evaluate estimates, or a network."), name="evaluate")


def main() -> None:
    """Run the command line; an error of the library, or a missing extra, is a sentence, not a traceback."""
    with complaints_of_the_store():
        try:
            app()
        except CorsmalError as error:
            complain("Error", error)
            sys.exit(1)
        except ModuleNotFoundError as error:
            advice = missing_extra(error)
            if advice is None:
                raise
            complain("Error", advice)
            sys.exit(1)
        except OSError as error:  # of a library that writes files of its own, such as a log of a training
            if error.errno not in FULL:
                raise
            complain("Error", f"{error.filename or 'a file'}: cannot be written ({error.strerror}); free the disk")
            sys.exit(1)


if __name__ == "__main__":
    main()
