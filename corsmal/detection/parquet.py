"""One view's detections as a Parquet file: a row per detection, what concerns the whole view in the metadata."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from corsmal.detection.record import Detections
from corsmal.detection.rle import BROKEN, checked_size, whole_counts
from corsmal.detection.view import ViewDetections
from corsmal.digests import digest
from corsmal.errors import FileError

BOX_COLUMNS = ("x_min_px", "y_min_px", "x_max_px", "y_max_px")
METADATA_KEY = b"corsmal.view"


def write_parquet(view_detections: ViewDetections, path: Path) -> None:
    """Write one view's detections, exactly and with every inspected frame.

    Raises:
        OSError: the file cannot be written.
    """
    records = list(view_detections.values())
    boxes = np.concatenate([np.empty((0, 4)), *(record.boxes for record in records)])
    frames = [frame for frame, record in view_detections.items() for _ in range(len(record))]
    columns: dict[str, Any] = {
        "frame": pa.array(frames, pa.int64()),
        **{name: pa.array(boxes[:, index]) for index, name in enumerate(BOX_COLUMNS)},
        "score": pa.array([score for record in records for score in record.scores], pa.float64()),
        "label": pa.array([label for record in records for label in record.labels], pa.int64()),
        "mask_rle": pa.array([counts for record in records for counts in record.counts], pa.binary()),
    }
    view = {
        "size": view_detections.size,
        "source": view_detections.source,
        "problems": view_detections.problems,
        "frames": view_detections.frames,
    }
    table = pa.table(columns)
    view["digest"] = _digest(view, table)
    table = table.replace_schema_metadata({METADATA_KEY: json.dumps(view)})
    pq.write_table(table, path, compression="zstd", write_page_checksum=True)


def read_parquet(path: Path, *, is_own: bool = False) -> ViewDetections:
    """Read what ``write_parquet`` wrote.

    Args:
        path: the file.
        is_own: this program wrote it into its own store, so that its digest is enough; else every mask is checked,
            which takes several times as long.

    Raises:
        FileError: the file was not written by it, or is broken.
        OSError, ValueError, KeyError, TypeError: it is broken.
        ArgumentError: the detections in it cannot be.
    """
    try:
        return _read(path, is_own=is_own)
    except pa.ArrowException as error:
        raise FileError(path, f"is broken ({error})") from error


def _read(path: Path, *, is_own: bool) -> ViewDetections:
    with pq.ParquetFile(path, page_checksum_verification=True) as file:
        table = file.read()
    metadata = table.schema.metadata or {}
    if METADATA_KEY not in metadata:
        raise FileError(path, "is not a file of detections")
    view = json.loads(metadata[METADATA_KEY])
    if view.pop("digest") != _digest(view, table):  # Parquet's own checksums leave out the metadata
        raise FileError(path, "holds other detections than were written")
    size = checked_size(view["size"])
    boxes = np.column_stack([table[name].to_numpy() for name in BOX_COLUMNS])
    scores, labels, row_frames = (table[name].to_numpy() for name in ("score", "label", "frame"))
    masks = table["mask_rle"].to_pylist()
    if not is_own and not whole_counts(masks, size).issuperset(masks):
        raise FileError(path, f"is broken: {BROKEN}")
    all_frames = Detections.from_counts(boxes, scores, labels, masks, size=size)
    rows = np.searchsorted(row_frames, [view["frames"], np.add(view["frames"], 1)]).T.tolist()
    by_frame = {frame: all_frames[first:after] for frame, (first, after) in zip(view["frames"], rows, strict=True)}
    if sum(map(len, by_frame.values())) != len(scores):
        raise FileError(path, "holds detections of frames that it does not list")
    return ViewDetections(by_frame, size=size, source=view["source"], problems=tuple(view["problems"]))


def _digest(view: dict[str, Any], table: pa.Table) -> str:
    """Of everything that is in a file."""
    masks = table["mask_rle"].to_pylist()
    columns = {name: table[name].to_numpy() for name in table.column_names if name != "mask_rle"}
    return digest(json.dumps(view), columns, np.array([len(counts) for counts in masks]), b"".join(masks))
