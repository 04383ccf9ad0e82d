"""The command line: ``python -m corsmal --help``."""

import sys

import typer

from corsmal.commands import complain, detector, evaluating, recordings
from corsmal.commands.doctor import doctor
from corsmal.errors import CorsmalError

app = typer.Typer(no_args_is_help=True, add_completion=False, pretty_exceptions_enable=False, help=__doc__)
for command in (
    recordings.demo, recordings.detect, recordings.estimate, doctor, evaluating.submit, evaluating.budget,
):  # fmt: skip
    app.command()(command)
app.add_typer(detector.app, name="train")
app.add_typer(evaluating.app, name="evaluate")


def main() -> None:
    """Run the command line; an error of the library is its sentence, not a traceback."""
    try:
        app()
    except CorsmalError as error:
        complain("Error", error)
        sys.exit(1)


if __name__ == "__main__":
    main()
