"""Networks of other programs: PyTorch's state dicts, of which only numbers are read, and at a bounded cost."""

import pickle
import pickletools
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from corsmal.errors import FileError

if TYPE_CHECKING:
    from torch import Tensor

Form = Literal["filling", "mass"]
Shapes = Mapping[str, tuple[int, ...]]

FILES: dict[Form, str] = {"filling": "task1and2.pt", "mass": "task4.pt"}
"""What the authors call their files."""

MARKS: dict[Form, str] = {"filling": "encoder.dconv.weight", "mass": "conv1.weight"}
"""The name of a tensor by which a network is recognised."""

BYTES_MAX = 32_000_000
"""Of all that a file holds once it is unpacked; the authors' files have 6 and 2 million."""

OPCODES_MAX = 20_000
"""Of the file's list of its tensors; the authors' have about 1600."""

ZIP_START = b"PK\x03\x04"

KNOWN_GLOBALS = {
    "collections OrderedDict",
    *(f"torch._utils _rebuild_{part}" for part in ("tensor_v2", "parameter")),
    *(f"torch {number}Storage" for number in ("Double", "Float", "Half", "BFloat16", "Long", "Int")),
}
"""All that the list of the tensors of a network names."""

READING_ERRORS = (
    pickle.UnpicklingError,
    zipfile.BadZipFile,
    ArithmeticError,
    AttributeError,
    EOFError,
    LookupError,
    MemoryError,
    NotImplementedError,
    OSError,
    RuntimeError,
    TypeError,
    ValueError,
)
"""What reading a broken file raises."""


def is_state_dict(path: Path) -> bool:
    """Whether a file is of the kind that ``torch.save`` writes; false where it cannot be read or is no file."""
    try:
        if not path.is_file():  # the reader of a pipe would wait
            return False
        with path.open("rb") as file:
            return file.read(len(ZIP_START)) == ZIP_START
    except OSError:
        return False


def read_state_dict(path: Path, form: Form, shapes: Shapes) -> "dict[str, Tensor]":
    """The tensors of one of the authors' networks, in single precision and on the CPU.

    The file is opened with ``weights_only=True``, after its size and all that it names were checked.

    Args:
        path: the file.
        form: which network it must be of.
        shapes: of the network's tensors, by their names; the file must hold these and no others.

    Raises:
        FileError: the file is absent, broken, too large, names anything but tensors, holds other tensors than those of
            ``shapes``, or numbers that are not finite.
    """
    import torch  # noqa: PLC0415 - loads PyTorch, which takes seconds

    _check_archive(path, form)
    try:
        content = torch.load(path, map_location="cpu", weights_only=True)
    except READING_ERRORS as error:
        raise _damaged(path, form) from error
    _check_names(path, content, form, shapes)
    for name, shape in shapes.items():
        value = content[name]
        is_plain = isinstance(value, torch.Tensor) and value.layout == torch.strided
        if not is_plain or tuple(value.shape) != shape:
            found = tuple(value.shape) if is_plain else type(value).__name__
            raise FileError(path, f"has {name} of {found} where {shape} is expected; {_advice(form)}")
        if not torch.isfinite(value).all():
            raise FileError(path, f"holds weights that are not finite, in {name}; {_advice(form)}")
    return {name: content[name].detach().float() for name in shapes}


def _check_archive(path: Path, form: Form) -> None:
    """Whether a file is no larger than it may be and names nothing but tensors."""
    try:
        with zipfile.ZipFile(path) as archive:
            size = sum(entry.file_size for entry in archive.infolist())
            if size > BYTES_MAX:
                limit = f"{BYTES_MAX / 1e6:.0f} MB"
                raise FileError(path, f"unpacks to more than {limit} and was not opened; {_advice(form)}")
            is_whole = archive.testzip() is None
            lists = [name for name in archive.namelist() if name.endswith("data.pkl")]
            named = [name for each in lists for name in _globals(archive.read(each))]
    except READING_ERRORS as error:
        raise _damaged(path, form) from error
    if not is_whole:
        raise _damaged(path, form)
    unknown = next((name for name in named if name not in KNOWN_GLOBALS), None)
    if unknown is not None:
        problem = f"names {unknown[:60].replace(' ', '.')!r}, may hold a program and was not opened"
        raise FileError(path, f"{problem}; {_advice(form)}")


def _globals(listing: bytes) -> list[str]:
    """What a pickle names, module and name; it is not run."""
    found = []
    for count, (opcode, argument, _) in enumerate(pickletools.genops(listing)):
        if count > OPCODES_MAX:
            raise pickle.UnpicklingError("too long")
        if opcode.name in ("GLOBAL", "INST"):
            found.append(str(argument))
        elif opcode.name in ("STACK_GLOBAL", "EXT1", "EXT2", "EXT4"):
            found.append(opcode.name)
    return found


def _check_names(path: Path, content: Any, form: Form, shapes: Shapes) -> None:
    names = list(content) if isinstance(content, Mapping) else []
    for other, mark in MARKS.items():
        if other != form and mark in names:
            problem = f"is the {other} network's file, not the {form} network's"
            options = f"`--{other}` or CORSMAL_{other.upper()}_WEIGHTS"
            raise FileError(path, f"{problem}; name it with {options}, and here {FILES[form]}")
    absent = [name for name in shapes if name not in names]
    extra = [str(name) for name in names if name not in shapes]
    if absent or extra:
        lacks = f"lacks {_some(absent)}" if absent else ""
        has = f"holds {_some(extra)} besides" if extra else ""
        raise FileError(path, f"{' and '.join(filter(None, (lacks, has)))}; {_advice(form)}")


def _some(names: list[str]) -> str:
    rest = f" and {len(names) - 1} more" if len(names) > 1 else ""
    return f"{names[0][:60]}{rest}"


def _damaged(path: Path, form: Form) -> FileError:
    return FileError(path, f"is incomplete or damaged; {_advice(form)}")


def _advice(form: Form) -> str:
    return f"name the authors' {FILES[form]} as it was published, or download it again"
