"""What the documents for developers name exists, and the rooms that they draw are those that the tests hold."""

import importlib
import re
from pathlib import Path

import pytest

from corsmal.dataset.plain_pickle import BYTES_CREATED_MAX, OPCODES_MAX
from corsmal.dataset.video_file import PIXELS_MAX
from corsmal.detection import coco
from corsmal.detection.polygons import POINTS_MAX, POLYGONS_MAX
from corsmal.ui.jobs import FAREWELL_S
from tests.test_architecture import FLOOR_OF, FLOORS

ROOT = Path(__file__).resolve().parents[1]
ARCHITECTURE = "docs/architecture.md"
DOCUMENTS = [ARCHITECTURE, "CONTRIBUTING.md"]
PATH = re.compile(r"[\w.-]*/[\w./-]*|[\w-]+\.(?:py|pyi|md|toml|txt|lock|yml|js|css|csv)")
NAME = re.compile(r"[a-z_]\w*(?:\.\w+)+")


def text_of(document: str) -> str:
    return (ROOT / document).read_text(encoding="utf-8")


def spelled(document: str, pattern: re.Pattern[str]) -> list[str]:
    """The words in `code` outside of blocks that are as a whole of a pattern; brackets of a call are left away."""
    text = re.sub(r"```.*?```", "", text_of(document), flags=re.DOTALL)
    words = [re.sub(r"\(.*\)$", "", word) for word in re.findall(r"`([^`\n]+)`", text)]
    return [word for word in words if pattern.fullmatch(word)]


def is_there(path: str) -> bool:
    """Whether a file or folder exists, named from the project's folder or from the library's."""
    return any((folder / path).exists() for folder in (ROOT, ROOT / "corsmal"))


def is_known(name: str) -> bool:
    """Whether a dotted name, with or without its ``corsmal.``, is a module or something in one."""
    parts = name.removeprefix("corsmal.").split(".")
    for count in range(len(parts), 0, -1):
        try:
            found = importlib.import_module(".".join(["corsmal", *parts[:count]]))
        except ModuleNotFoundError:
            continue
        for part in parts[count:]:
            if not hasattr(found, part) and part not in getattr(found, "__dataclass_fields__", {}):
                return False
            found = getattr(found, part, None)
        return True
    return False


@pytest.mark.parametrize("document", DOCUMENTS)
def test_every_path_exists(document):
    paths = spelled(document, PATH)
    assert len(paths) > 5
    assert [path for path in paths if not is_there(path)] == []


@pytest.mark.parametrize("document", DOCUMENTS)
def test_every_name_exists(document):
    names = [name for name in spelled(document, NAME) if not PATH.fullmatch(name)]
    assert len(names) > 5
    assert [name for name in names if not is_known(name)] == []


def test_what_does_not_exist_is_noticed():
    assert not is_there("corsmal/nothing.py")
    assert not is_known("shape.nothing")
    assert not is_known("nothing.fit_hull")
    assert is_known("shape.fit_hull")
    assert is_known("corsmal.dataset.Recording.views")


def test_the_floors_are_those_of_the_architecture_test():
    [figure] = re.findall(r"```text\n(.*?)```", text_of(ARCHITECTURE), re.DOTALL)
    drawn = [tuple(line.split()) for line in figure.splitlines()]
    assert drawn == list(reversed(FLOORS))


def test_every_room_has_its_line():
    rooms = re.findall(r"^\| `(\w+)(?:\.py)?/?` \|", text_of(ARCHITECTURE), re.MULTILINE)
    assert sorted(rooms) == sorted(FLOOR_OF)


def test_the_security_page_names_the_limits_that_the_code_has():
    text = " ".join(text_of("docs/security.md").split())
    limits = (
        f"At most {OPCODES_MAX} instructions and {BYTES_CREATED_MAX // 10**6} MB are made of it",
        f"At most {coco.BYTES_MAX // 10**6} MB",
        f"of a frame {coco.FRAME_ENTRIES_MAX} detections, of a mask {POLYGONS_MAX} polygons and {POINTS_MAX:,} points",
        f"pictures of more than {PIXELS_MAX // 10**6} million pixels",
        f"ends within {'five' if FAREWELL_S < 5 else FAREWELL_S} seconds",
    )
    assert [limit for limit in limits if limit not in text] == []


def test_every_command_of_contributing_names_what_is_there():
    commands = re.findall(r"^\.venv/bin/([^#\n]*)", text_of("CONTRIBUTING.md"), re.MULTILINE)
    assert len(commands) > 3
    paths = [word for command in commands for word in command.split() if re.match(r"(tests|app)\b", word)]
    assert [path for path in paths if not is_there(path)] == []
