"""``app``: the app, in a browser."""

from pathlib import Path
from typing import Annotated

import typer


def app(
    *,
    data: Annotated[Path | None, typer.Option(metavar="DIR", help="Dataset to open; default: the demo.")] = None,
    data_root: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Open only datasets in this folder, by their names there.")
    ] = None,
    read_only: Annotated[bool, typer.Option("--read-only", help="Let visitors look, but change nothing.")] = False,
    port: Annotated[int, typer.Option(help="Port to listen on.", min=1, max=65535)] = 8501,
    base_path: Annotated[str, typer.Option(help="Path below which a web server offers the app.")] = "",
    no_browser: Annotated[bool, typer.Option("--no-browser", help="Open no browser.")] = False,
) -> None:
    """Start the app on this machine, and open it in the browser.

    Streamlit's other settings are read from the environment, such as STREAMLIT_SERVER_ADDRESS.
    """
    from streamlit.web import cli

    from corsmal.installation import app_script

    chosen = {"--data": data, "--data-root": data_root}
    own = [word for option, folder in chosen.items() if folder is not None for word in (option, str(folder))]
    server = {"port": str(port), "baseUrlPath": base_path, "headless": str(no_browser).lower()}
    options = [f"--server.{name}={value}" for name, value in server.items()]
    cli.main(["run", str(app_script()), *options, "--", *own, *(["--read-only"] if read_only else [])])
