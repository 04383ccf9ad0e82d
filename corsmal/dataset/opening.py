"""A dataset: the recordings of one folder, and a table of what is known about them."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import asdict, replace
from functools import cached_property
from pathlib import Path

import pandas as pd

from corsmal.dataset.annotation import FIELDS, Annotation
from corsmal.dataset.annotation_file import Annotations
from corsmal.dataset.annotation_places import find_annotations
from corsmal.dataset.clock import Matching
from corsmal.dataset.findings import Finding, in_order
from corsmal.dataset.ids import listed, recording_id
from corsmal.dataset.layout import Masks, Recording
from corsmal.dataset.older_layout import known_by_names
from corsmal.dataset.places import listing
from corsmal.dataset.published import CUTS_S, cut_findings, cut_s
from corsmal.dataset.scanning import Layout, has_layout, is_part, scan
from corsmal.digests import digest
from corsmal.errors import FileError, NotFoundError

EXPECTED = "view1/rgb/000618.mp4, view1/calib/000618.pickle, audio/000618.wav and an annotation (.json or .csv)"
"""The layout, by example, for messages."""

_WHOLE_NUMBERS = ("container_id", "scenario", "background", "illumination", "filling_type", "filling_level")
_TEXTS = ("container", "kind", "filling", "level", "missing")
_COLUMNS = (
    *FIELDS[: FIELDS.index("filling_type") + 1],
    "filling",
    "filling_level",
    "level",
    "filling_density_g_per_ml",
    "filling_mass_g",
    "missing",
)


class Dataset:
    """The recordings of one folder, in the order of their ids.

    Args:
        recordings: by id.
        findings: what is to be known about the folder and its files by their names and tables.

    Example:
        >>> dataset = open_dataset("ccm/train")  # doctest: +SKIP
        >>> dataset["000618"].annotation.capacity_ml  # doctest: +SKIP
        520.0
    """

    def __init__(self, root: Path, recordings: Mapping[str, Recording], *, findings: Iterable[Finding] = ()) -> None:
        self.root = root
        self.name = root.name or str(root)
        self.findings = tuple(in_order(findings))
        self._recordings = {name: recordings[name] for name in sorted(recordings)}

    def __len__(self) -> int:
        return len(self._recordings)

    def __iter__(self) -> Iterator[Recording]:
        return iter(self._recordings.values())

    def __contains__(self, name: object) -> bool:
        return recording_id(name) in self._recordings or name in self._recordings

    def __getitem__(self, name: str | int) -> Recording:
        """One recording.

        Args:
            name: its id; 618 and ``"618"`` mean ``"000618"``.

        Raises:
            NotFoundError: the dataset has no such recording; the text says which it has.
        """
        for candidate in (name, recording_id(name)):
            if isinstance(candidate, str) and candidate in self._recordings:
                return self._recordings[candidate]
        wanted = recording_id(name) or str(name)
        held = f"{len(self)} recordings, {self.ids[0]} to {self.ids[-1]}" if len(self) else "no recordings"
        raise NotFoundError(f"there is no recording {wanted[:40]!r} in {self.name}: it holds {held}")

    def matched(self, matching: Matching, *, masks: Masks = "detected") -> "Dataset":
        """The same recordings, their views' frames matched in another way, and with other masks in use."""
        recordings = {
            name: replace(recording, matching=matching, masks=masks) for name, recording in self._recordings.items()
        }
        return Dataset(self.root, recordings, findings=self.findings)

    @property
    def problems(self) -> tuple[str, ...]:
        """Sentences on what the set lacks, what is wrong and what was assumed; of unused files how many there are."""
        of_set = (finding for finding in self.findings if not finding.recording and finding.kind != "unused")
        problems = [str(finding) for finding in of_set]
        unused = sum(finding.kind == "unused" and finding.is_problem for finding in self.findings)
        if unused:
            files = "1 file is" if unused == 1 else f"{unused} files are"
            problems.append(f"{files} not used; the Recordings page and doctor name the reasons")
        return tuple(problems)

    @property
    def ids(self) -> tuple[str, ...]:
        """The recordings' ids, in order."""
        return tuple(self._recordings)

    @cached_property
    def fingerprint(self) -> str:
        """Eight hexadecimal digits of the recordings' ids and what is annotated: the same wherever the set is copied.

        No recording is read, and which files are there does not count, unless there is no annotation to name them.
        """
        return digest("dataset", [(recording.id, recording.annotation) for recording in self])[:8]

    @cached_property
    def table(self) -> pd.DataFrame:
        """What is known, one row per recording, indexed by ``id``; NA where it is unknown.

        Columns: the fields of ``Annotation``, ``filling`` and ``level`` (names of type and level), and ``missing``
        (what the recording lacks, separated by commas; empty when complete).
        """
        unknown = Annotation()
        rows = []
        for recording in self:
            known = recording.annotation or unknown
            names = {"filling": known.filling, "level": known.level, "missing": ", ".join(recording.missing)}
            rows.append(asdict(known) | names)
        index = pd.Index(self.ids, name="id", dtype="str")
        table = pd.DataFrame(rows, index=index, columns=list(_COLUMNS))
        types = {
            column: "Int64" if column in _WHOLE_NUMBERS else "string" if column in _TEXTS else "Float64"
            for column in _COLUMNS
        }
        return table.astype(types)


def open_dataset(root: str | Path) -> Dataset:
    """Index a dataset folder from its file names and its annotation; no video is opened.

    Args:
        root: a folder of the layout of CORSMAL Containers Manipulation, the present or the older one. Any part of it
            may be absent; the annotation may lie beside it.

    Raises:
        FileError: the folder is absent, is no folder, or holds nothing of this layout.
    """
    root = _existing_folder(root)
    layout = scan(root)
    annotations = find_annotations(root, layout.top, ids=layout.ids)
    known = known_by_names(layout.known, annotations) if layout.is_older else annotations.by_id
    ids = layout.ids if layout.is_older else layout.ids | set(known)
    if not layout.ids and (hint := _hint(root)):
        raise FileError(root, f"holds no files of recordings{hint}")
    if not ids:
        problem = next((str(found) for found in annotations.findings if found.severity == "error"), None)
        expected = f"expected files such as {EXPECTED}"
        raise FileError(
            root, f"holds no recordings; {expected}" if problem is None else f"holds no recordings: {problem}"
        )
    ends_s = {name: cut_s(name, known.get(name), ids=ids) for name in ids & CUTS_S.keys()}
    recordings = {name: layout.recording(name, known.get(name), sound_end_s=ends_s.get(name)) for name in ids}
    if annotations.is_synthetic:
        recordings = {name: replace(each, is_annotated_synthetic=True) for name, each in recordings.items()}
    return Dataset(root, recordings, findings=_findings(layout, annotations, ends_s))


def _findings(layout: Layout, annotations: Annotations, ends_s: Mapping[str, float | None]) -> Iterator[Finding]:
    """What opening a folder found."""
    if layout.is_older:
        what = "the folder has the dataset's older layout; its names say what was recorded"
        yield Finding("note", "name", what)
    yield from annotations.findings
    annotated, filmed = set(annotations.by_id), layout.ids
    if annotated and filmed and not layout.is_older and not annotated & filmed:
        what = f"the annotation has none of the recordings' ids: {listed(sorted(filmed))} there, {min(annotated)} here"
        yield Finding("warning", "annotation", what, advice="name the files after the annotation's ids")
    if annotations.by_container and not layout.is_older:
        what = "the annotation is not used: it has no column 'id', so its rows are of no recordings"
        yield Finding("warning", "annotation", what, advice="name the column with the recordings' ids")
    if renamed := layout.named_otherwise():
        name, path = renamed[0]
        what = f"{len(renamed)} file{'s are' if len(renamed) > 1 else ' is'} named otherwise than the recording's id"
        yield Finding("note", "name", f"{what}, such as {path.name} of {name}")
    yield from (Finding("note", "missing", sentence) for sentence in layout.absent_parts())
    yield from layout.findings
    yield from cut_findings({name: end_s for name, end_s in ends_s.items() if name in layout.sounds})


def _existing_folder(root: str | Path) -> Path:
    """The folder's full path, whatever a person typed."""
    wanted = "name the folder of a dataset, such as .../train"
    try:
        folder = Path(root).expanduser().resolve()
        is_there, is_folder = folder.exists(), folder.is_dir()
    except (OSError, RuntimeError, ValueError) as error:
        raise FileError(root, f"this folder cannot be opened ({error}); {wanted}") from error
    if not is_there:
        raise FileError(root, f"there is no such folder; {wanted}")
    if not is_folder:
        raise FileError(root, f"is a file; {wanted}")
    return folder


def _hint(root: Path) -> str:
    """Where the dataset may be instead: one level down, or above its folder of a view, of sounds or of a part."""
    try:
        inner = [name for name in listing(root).folders if has_layout(root / name)]
        above = next((folder for folder in root.parents[:2] if is_part(root, of=folder)), None)
    except FileError:
        return ""
    if inner:
        return f"; did you mean its folder {inner[0]!r}?"
    return f"; did you mean the folder {str(above)!r}?" if above is not None else ""
