"""Where the app lies on its server."""

from streamlit import config


def with_base(path: str) -> str:
    """A path of the app's own, such as ``/thumbnails``, below ``server.baseUrlPath``."""
    base = str(config.get_option("server.baseUrlPath") or "").strip("/")
    return f"/{base}{path}" if base else path
