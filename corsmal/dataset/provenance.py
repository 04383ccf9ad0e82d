"""Which recordings a network was trained on, so that no table counts what it has already seen."""

from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, field, replace
from typing import Any

from corsmal.dataset.layout import Recording
from corsmal.errors import ArgumentError

Parts = Mapping[str, int | str]
"""What a recording is recognised by besides its id, by the name of the part."""


@dataclass(frozen=True)
class TrainedOn:
    """What a network was trained on, kept in its weights.

    Args:
        recordings: id of each recording to its parts, see ``parts_of``. Those that chose the epoch are among them.
        is_synthetic: whether they are rendered and not filmed; None where the network has seen both.
        protocol: ``held-out`` or ``paper`` for a fold of a cross-validation, ``all`` for a final network.
        fold: of the cross-validation; None for a final network.
        facts: what else belongs to the training and JSON can hold, such as the training set's means.
    """

    recordings: Mapping[str, Parts]
    is_synthetic: bool | None
    protocol: str = "all"
    fold: int | None = None
    facts: Mapping[str, Any] = field(default_factory=dict)

    @classmethod
    def of(cls, recordings: Iterable[Recording], *, features: Mapping[str, str] | None = None) -> "TrainedOn":
        """What a final network is trained on; ``features`` are digests, by id, of arrays instead of the sound."""
        known, kinds = {}, set()
        for recording in recordings:
            known[recording.id] = parts_of(recording, features=(features or {}).get(recording.id))
            kinds.add(recording.is_synthetic)
        return cls(known, kinds.pop() if len(kinds) == 1 else None)

    def part(self, ids: Iterable[str], *, protocol: str, fold: int) -> "TrainedOn":
        """What one network of a cross-validation is trained on."""
        return replace(self, recordings={name: self.recordings[name] for name in ids}, protocol=protocol, fold=fold)

    def has_seen(self, recording: Recording, *, features: str | None = None) -> bool:
        """Whether the network may have been trained on a recording, whose array, if any, has the digest ``features``.

        The same id is enough unless a part that is known on both sides differs: recordings of other sets carry the same
        numbers. What cannot be distinguished counts as seen.
        """
        if recording.id not in self.recordings:
            return False
        theirs, own = self.recordings[recording.id], parts_of(recording, features=features)
        return all(theirs[name] == own[name] for name in theirs.keys() & own.keys())

    def to_json(self) -> dict[str, Any]:
        """What ``from_json`` reads."""
        return asdict(self)

    @classmethod
    def from_json(cls, content: Mapping[str, Any]) -> "TrainedOn | None":
        """The record of a file of weights; None where the file does not say what it was trained on.

        Raises:
            ArgumentError: it is something else.
        """
        if not content.get("recordings"):
            return None
        try:
            recordings = {str(name): dict(parts) for name, parts in content["recordings"].items()}
            facts = dict(content["facts"])
            return cls(recordings, content["is_synthetic"], str(content["protocol"]), content["fold"], facts)
        except (AttributeError, LookupError, TypeError, ValueError) as error:
            raise ArgumentError(f"content must say what a network was trained on, got {str(content)[:60]}") from error


def parts_of(recording: Recording, *, features: str | None = None) -> dict[str, int | str]:
    """What a recording is recognised by, whichever folder it is copied to: its files' sizes, and its container.

    Returns:
        ``audio`` and ``view1`` to ``view4`` in bytes, ``container``, and ``features``, the digest of its array; what
        there is of them.
    """
    paths = {name: view.video_path for name, view in recording.views.items()}
    if recording.audio_path is not None:
        paths["audio"] = recording.audio_path
    parts: dict[str, int | str] = {name: path.stat().st_size for name, path in paths.items() if path.is_file()}
    if recording.annotation is not None and recording.annotation.container_id is not None:
        parts["container"] = recording.annotation.container_id
    return parts if features is None else parts | {"features": features}
