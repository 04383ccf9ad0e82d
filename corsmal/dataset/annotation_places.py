"""Where a dataset's annotation lies: in its folder, in a folder ``annotations``, or beside the folder."""

import re
from collections.abc import Collection, Iterable, Iterator
from dataclasses import replace
from pathlib import Path

from corsmal.dataset.annotation_file import Annotations, read_annotation_file
from corsmal.dataset.findings import Finding, Severity
from corsmal.dataset.places import listing, shown_path
from corsmal.errors import FileError

_ANNOTATION = re.compile(r".*annotation.*\.(json|csv|tsv|txt)", re.IGNORECASE)
_SPREADSHEET = re.compile(r".*annotation.*\.(xlsx?|ods|numbers)", re.IGNORECASE)
_TABLES = (".json", ".csv", ".tsv", ".xlsx", ".xls", ".ods")
_FOLDERS = ("annotation", "annotations")
_SETS = {"train", "training", "test", "public", "private", "pub", "pri", "val", "validation", "demo"}
"""Words by which a name says of which set a file or folder is."""


def read_annotations(root: Path, names: Iterable[str]) -> Annotations:
    """Read the annotation of a folder as far as it can be used, with findings on the rest.

    Of the files ``names`` in it the first is taken whose name contains ``annotation`` and that can be read, JSON before
    CSV.
    """
    names = list(names)
    findings = [
        Finding("warning", "annotation", "is a spreadsheet and not read", file=name, advice="save it as CSV")
        for name in sorted(names)
        if _SPREADSHEET.fullmatch(name)
    ]
    found: Annotations | None = None
    used = ""
    for name in candidates(names):
        if found is not None:
            findings.append(Finding("note", "unused", f"is not used: {used} is the annotation", file=name))
            continue
        try:
            found, used = read_annotation_file(root / name, file=name), name
        except FileError as error:
            is_remark = name.lower().endswith(".txt")
            kind = "unused" if is_remark else "annotation"
            findings.append(Finding("note" if is_remark else "error", kind, error.problem, file=name))
    if found is None:
        return Annotations({}, tuple(findings))
    return replace(found, findings=(*findings, *found.findings))


def find_annotations(root: Path, names: Iterable[str], *, ids: Collection[str]) -> Annotations:
    """Read the annotation in a folder, else in its folder ``annotations``, else beside it.

    Args:
        root: the folder.
        names: of its files.
        ids: of the recordings that have files: what lies beside the folder is only used if it has one of them.
    """
    names = list(names)
    found = _annotations_of(root, names, ids=ids)
    severity: Severity = "note" if found.by_id or found.by_container else "warning"
    return replace(found, findings=(*found.findings, *_other_tables(names, severity)))


def _annotations_of(root: Path, names: list[str], *, ids: Collection[str]) -> Annotations:
    found = read_annotations(root, names)
    if found.by_id or found.by_container or any(finding.severity == "error" for finding in found.findings):
        return found
    for place in (*(root / name for name in _FOLDERS), root.parent, *(root.parent / name for name in _FOLDERS)):
        is_beside = not place.is_relative_to(root)
        inside = [name for name in _listed(place) if not is_beside or not _is_of_another_set(name, root.name)]
        other = _read_elsewhere(place, inside, root=root, ids=ids) if candidates(inside) else None
        if other is not None:
            return replace(other, findings=(*found.findings, *other.findings))
    if not found.findings:
        what = f"no annotation was found: {root} holds no file like ccm_train_annotation.json or .csv"
        return Annotations({}, (Finding("note", "missing", what),))
    return found


def _other_tables(names: Iterable[str], severity: Severity) -> Iterator[Finding]:
    """Tables in a set's folder that no name tells to be its annotation."""
    for name in names:
        is_named = _ANNOTATION.fullmatch(name) or _SPREADSHEET.fullmatch(name)
        if Path(name).suffix.lower() in _TABLES and not is_named:
            advice = "rename it to ccm_train_annotation.json or .csv if it is the annotation"
            yield Finding(severity, "unused", "is not used", file=name, advice=advice)


def candidates(names: Iterable[str]) -> list[str]:
    """Names that an annotation may have, in the order in which they are tried."""
    found = sorted(name for name in names if _ANNOTATION.fullmatch(name))
    return sorted(found, key=lambda name: not name.lower().endswith(".json"))


def _read_elsewhere(place: Path, names: list[str], *, root: Path, ids: Collection[str]) -> Annotations | None:
    """An annotation that does not lie in the folder itself; None where it is none of the recordings'."""
    stems = {Path(name).stem for name in candidates(names)}
    is_beside = not place.is_relative_to(root)
    if len(stems) > 1 and is_beside:
        several = " and ".join(sorted(stems)[:3])
        what = f"annotations of several sets lie beside the folder ({several}) and none is used"
        return Annotations({}, (Finding("warning", "annotation", what, advice=f"put the right one into {root}"),))
    read = read_annotations(place, names)
    where = "beside the folder" if is_beside else f"in the folder {place.name}"
    named = [replace(finding, file=shown_path(place / finding.file, root)) for finding in read.findings]
    if is_beside and not set(ids) & set(read.by_id) and not read.by_container:
        broken = [replace(finding, severity="warning") for finding in named if finding.severity == "error"]
        return Annotations({}, tuple(broken)) if broken else None
    used = candidates(names)[0]
    lies = Finding(
        "note", "annotation", f"is used as the annotation; it lies {where}", file=shown_path(place / used, root)
    )
    return replace(read, findings=(lies, *named))


def _is_of_another_set(name: str, folder: str) -> bool:
    """Whether a file's name says that it is of another set than a folder's name."""
    file, own = (set(re.split(r"[^a-z]+", text.lower())) & _SETS for text in (name, folder))
    return bool(file and own) and not own <= file


def _listed(folder: Path) -> list[str]:
    try:
        return list(listing(folder).files)
    except FileError:
        return []
