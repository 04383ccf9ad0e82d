"""The site: it builds without a warning, its examples run, and what it must cover it covers."""

import ast
import doctest
import importlib
import importlib.util
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from corsmal.dataset import open_dataset
from corsmal.estimation import estimate, file_detections
from corsmal.evaluation import estimates_table
from corsmal.evaluation.rules import PUBLISHED, average_errors, average_texts, side_by_side
from corsmal.parameters import SHAPE_PRESETS
from corsmal.runs.rules import ALONE, RULES, conditions

ROOT = Path(__file__).resolve().parents[2]
SITE = ROOT / "docs"
PAGES = sorted(SITE.rglob("*.md"))
EXAMPLES = {path: re.findall(r"```python\n(.*?)```", path.read_text(encoding="utf-8"), re.DOTALL) for path in PAGES}
LIBRARY = sorted((ROOT / "corsmal").rglob("*.py"))
PICTURES_MB_MAX = 4.0


def name_of(path: Path) -> str:
    return str(path.relative_to(ROOT))


def test_the_site_builds_without_a_warning(tmp_path):
    """Links between pages, their anchors, and every name of the API pages are among what is checked."""
    if importlib.util.find_spec("mkdocs") is None or importlib.util.find_spec("mkdocstrings_handlers") is None:
        pytest.skip("needs the extra docs")
    build = [sys.executable, "-m", "mkdocs", "build", "--strict", "--site-dir", str(tmp_path)]
    environment = os.environ | {"NO_MKDOCS_2_WARNING": "1"}
    result = subprocess.run(build, cwd=ROOT, env=environment, capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stderr
    for path in tmp_path.rglob("*.html"):
        fetched = re.findall(r"(?:src|<link[^>]*href)=[\"'](https?://[^\"']+)", path.read_text(encoding="utf-8"))
        assert fetched == [], path.name


@pytest.mark.parametrize("page", [path for path, blocks in EXAMPLES.items() if blocks], ids=name_of)
def test_the_examples_of_a_page_run(page, tmp_path, monkeypatch, capsys):
    """One after the other, in a new folder, with the demo in a new store."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("CORSMAL_CACHE", str(tmp_path / "cache"))
    names: dict[str, object] = {"__name__": "example"}
    for block in EXAMPLES[page]:
        exec(compile(block, name_of(page), "exec"), names)
    assert "None" not in capsys.readouterr().out.split()


def examples_of(path: Path) -> list[doctest.DocTest]:
    if ">>>" not in path.read_text(encoding="utf-8"):
        return []
    module = importlib.import_module(".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__"))
    return [found for found in doctest.DocTestFinder().find(module) if found.examples]


def test_the_examples_of_docstrings_run():
    """Those that are marked to be skipped need files, and their names are those of real ones."""
    runner, count = doctest.DocTestRunner(), 0
    for path in LIBRARY:
        for found in examples_of(path):
            runner.run(found)
            count += sum(not example.options.get(doctest.SKIP) for example in found.examples)
    assert count > 10
    assert runner.summarize().failed == 0


def test_the_table_of_presets_is_that_of_the_demo(store):
    spec = importlib.util.spec_from_file_location("figures_of_the_site", SITE / "figures.py")
    figures = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(figures)
    assert figures.presets_table(store) == (SITE / "pictures" / "tuned.md").read_text(encoding="utf-8")


def test_every_kind_of_finding_is_explained():
    kinds = {
        keyword.value.value
        for path in LIBRARY
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.Call)
        for keyword in node.keywords
        if keyword.arg == "kind" and path.name == "doctor.py" and isinstance(keyword.value, ast.Constant)
    }
    for path in LIBRARY:
        kinds |= set(re.findall(r"Finding\(\s*\"\w+\"(?: if [^,]+)?,\s*\"(\w+)\"", path.read_text(encoding="utf-8")))
        kinds |= set(re.findall(r"_noting\(findings, \"(\w+)\"\)", path.read_text(encoding="utf-8")))
    assert {"missing", "calibration", "agreement", "cache"} <= kinds
    explained = re.findall(r"^### `(\w+)`$", (SITE / "faq.md").read_text(encoding="utf-8"), re.MULTILINE)
    assert sorted(kinds - set(explained)) == []


def test_every_page_of_the_app_has_a_picture():
    text = (SITE / "pages.md").read_text(encoding="utf-8")
    for path in (ROOT / "pages").glob("*.py"):
        assert f"\n## {path.stem.capitalize()}\n" in text
        assert f"(pictures/{path.stem}.png)" in text
        assert (SITE / "pictures" / f"{path.stem}.png").is_file()


def test_the_pictures_are_small():
    pictures = list(SITE.rglob("*.png"))
    assert len(pictures) > 10
    assert sum(path.stat().st_size for path in pictures) < 1e6 * PICTURES_MB_MAX
    text = "".join(path.read_text(encoding="utf-8") for path in (*PAGES, ROOT / "README.md"))
    assert [path.name for path in pictures if f"{path.name})" not in text] == []


@pytest.mark.parametrize("name", ["README.md", "CONTRIBUTING.md", "CHANGELOG.md"])
def test_the_links_of_other_documents_lead_somewhere(name):
    text = (ROOT / name).read_text(encoding="utf-8")
    links = [link.partition("#") for link in re.findall(r"\]\(([^)\s]+)\)", text) if "://" not in link]
    assert [path for path, _, _ in links if path and not (ROOT / path).exists()] == []
    anchors = {
        re.sub(r"[^\w\- ]", "", title).strip().lower().replace(" ", "-")
        for title in re.findall(r"^#+ (.*)", text, re.M)
    }
    assert [anchor for path, _, anchor in links if not path and anchor not in anchors] == []


def rows_of(document: str, heading: str) -> dict[str, list[str]]:
    """The first table below a heading: the cells of each row by its first one."""
    text = (SITE / document).read_text(encoding="utf-8").split(f"\n{heading}\n")[1]
    lines = [line.strip("| ").split(" | ") for line in text.split("\n\n")[1].splitlines()]
    return {line[0]: line[1:] for line in lines[2:]}


def test_the_difference_tables_have_every_preset_and_rule():
    names = [PUBLISHED, *SHAPE_PRESETS, *(f"{ALONE}{rule}" for rule in RULES)]
    for heading in ("### The demo: thirty synthetic recordings", "### 000618: one real recording"):
        assert list(rows_of("paper-and-program.md", heading)) == names


def test_the_difference_table_of_the_real_recording_is_what_comes_out(real_dataset_root):
    dataset = open_dataset(real_dataset_root)
    detections, _ = file_detections(dataset["000618"])
    shown = rows_of("paper-and-program.md", "### 000618: one real recording")
    for name in ("paper", "released", f"{ALONE}height rule", f"{ALONE}pairs"):
        made_with = conditions()[name]
        row = estimate(
            dataset["000618"], detections=detections, shape=made_with.shape, selection=made_with.selection
        ).row()
        found = average_errors(side_by_side({name: estimates_table([row])}, dataset.table), [name])
        assert list(average_texts(found).loc[name]) == shown[name]
