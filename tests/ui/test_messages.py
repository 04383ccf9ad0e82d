"""Texts of others in places that read Markdown."""

import re

import pytest

from corsmal.detection.coco_weights import COCO_WEIGHTS_URL
from corsmal.ui.messages import WORD_JOINER, plain

LINK = re.compile(r"(https?://|www(?=\.))([-.\w]+)([^ \t\r\n]*)", re.IGNORECASE)
"""What Markdown with GitHub's additions takes for addresses in a text, after its escapes were read."""

TEXTS = (
    "www.example.org",
    "see WWW.example.org/x, (www.example.org)",
    "http://example.org https://example.org",
    "/data/somebody@example.org/train",
    "[x](http://a.b) <b>&amp;</b> `x` $x$ :material/home: **x** ~~x~~ | # -",
    "/data/train/view1/rgb/000618.mp4: there is no such video file",
)


@pytest.mark.parametrize("text", TEXTS)
def test_texts_are_shown_as_they_are_and_no_part_becomes_a_link(text: str) -> None:
    shown = re.sub(r"\\([^a-zA-Z0-9\s])", r"\1", plain(text))
    assert not LINK.search(shown)
    assert shown.replace(WORD_JOINER, "") == text
    assert not re.search(r"(?<!\\)[`*\[\]<>$|:~]", plain(text))


def test_where_weights_are_downloaded_from_can_be_clicked_and_copied() -> None:
    assert plain(COCO_WEIGHTS_URL).replace("\\", "") == COCO_WEIGHTS_URL
