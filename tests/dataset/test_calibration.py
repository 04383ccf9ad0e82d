import os
import pickle
import resource
import subprocess
import time
from collections import OrderedDict
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from corsmal.dataset.calibration import BYTES_MAX, read_calibration, read_camera
from corsmal.errors import FileError
from corsmal.notes import flags_of
from tests.tiny import CALIBRATED_SIZE, tiny_cameras, write_calibration

CAMERA = tiny_cameras(CALIBRATED_SIZE)["view1"]


def _content(**replaced: object) -> list[Any]:
    """The dataset's structure, with some of its parts replaced."""
    parts = {"intrinsic": CAMERA.intrinsic, "rvec": CAMERA.rotation, "tvec": CAMERA.translation[:, None]} | replaced
    return [{"rgb": parts["intrinsic"]}, {"rgb": {"rvec": parts["rvec"], "tvec": parts["tvec"]}}]


def _write(path: Path, content: object, *, protocol: int = 2) -> Path:
    path.write_bytes(pickle.dumps(content, protocol=protocol))
    return path


def _assert_is_camera(path: Path) -> None:
    camera = read_camera(path)
    assert camera.size == (1280, 720)
    np.testing.assert_array_equal(camera.projection, CAMERA.projection)


def test_datasets_own_form_is_read(tmp_path: Path) -> None:
    path = write_calibration(tmp_path / "000000.pickle", CAMERA)
    assert b"cnumpy.core.multiarray" in path.read_bytes()
    _assert_is_camera(path)


@pytest.mark.parametrize("protocol", range(6))
@pytest.mark.parametrize("form", [list, tuple])
def test_every_protocol_is_read(tmp_path: Path, protocol: int, form: type) -> None:
    _assert_is_camera(_write(tmp_path / "c.pickle", form(_content()), protocol=protocol))


def test_python_2_text_with_bytes_above_127_is_read(tmp_path: Path) -> None:
    raw = "".join(f"\\x{byte:02x}" for byte in CAMERA.intrinsic.tobytes())
    array = (
        "cnumpy.core.multiarray\n_reconstruct\n(cnumpy\nndarray\n(I0\ntS'b'\ntR(I1\n(I3\nI3\ntcnumpy\ndtype\n"
        f"(S'f8'\nI0\nI1\ntR(I3\nS'<'\nNNNI-1\nI-1\nI0\ntbI00\nS'{raw}'\ntb"
    )
    rest = pickle.dumps(_content()[1], protocol=0)[:-1].decode("latin1")
    (tmp_path / "c.pickle").write_bytes(f"((dS'rgb'\n{array}s{rest}t.".encode("latin1"))
    _assert_is_camera(tmp_path / "c.pickle")


@pytest.mark.parametrize(
    "change",
    [
        {"intrinsic": CAMERA.intrinsic.tolist()},
        {"intrinsic": np.asfortranarray(CAMERA.intrinsic)},
        {"intrinsic": CAMERA.intrinsic.astype(">f8")},
        {"tvec": CAMERA.translation},
        {"tvec": [np.float64(value) for value in CAMERA.translation]},
    ],
    ids=range(5),
)
def test_other_ways_to_write_the_same_numbers(tmp_path: Path, change: dict[str, object]) -> None:
    _assert_is_camera(_write(tmp_path / "c.pickle", _content(**change)))


def _with_projection(matrix: object, **replaced: object) -> list[Any]:
    content = _content(**replaced)
    content[1]["rgb"]["projMatrix"] = matrix
    return content


def test_a_projection_matrix_that_contradicts_is_noted_and_not_used(tmp_path: Path) -> None:
    feet = _with_projection(CAMERA.projection, tvec=CAMERA.translation * 3.28)
    found = read_calibration(_write(tmp_path / "feet.pickle", feet))
    np.testing.assert_allclose(found.camera.translation, CAMERA.translation * 3.28)
    [note] = found.notes
    assert note.startswith("'projMatrix' contradicts 'rvec' and 'tvec', which were used: points lie ")
    assert flags_of(found.notes) == ("implausible",)
    mm = _with_projection(CAMERA.projection, tvec=CAMERA.translation * 1000)
    assert flags_of(read_calibration(_write(tmp_path / "mm.pickle", mm)).notes) == ("unit-assumed",)


@pytest.mark.parametrize(
    "matrix",
    [
        CAMERA.projection,
        CAMERA.projection * -7.5,
        None,
        "P",
        np.zeros((3, 4)),
        np.full((3, 4), np.nan),
        np.eye(3),
        [1e308] * 12,
    ],
    ids=range(8),
)
def test_a_projection_matrix_that_agrees_or_is_none_says_nothing(tmp_path: Path, matrix: object) -> None:
    assert read_calibration(_write(tmp_path / "c.pickle", _with_projection(matrix))).notes == ()


def test_ordered_dictionaries_are_read(tmp_path: Path) -> None:
    intrinsics, extrinsics = _content()
    _assert_is_camera(_write(tmp_path / "c.pickle", [OrderedDict(intrinsics), OrderedDict(extrinsics)]))


class _Runs:
    """Unpickles by calling a function."""

    def __init__(self, function: object, *arguments: object) -> None:
        self.call = (function, arguments)

    def __reduce__(self) -> tuple[Any, ...]:
        return self.call


@pytest.mark.parametrize("protocol", [0, 2, 4])
@pytest.mark.parametrize("function", [os.system, subprocess.check_call, eval, exec, getattr, __import__, np.load])
def test_pickle_that_calls_a_function_runs_nothing(tmp_path: Path, function: object, protocol: int) -> None:
    trace = tmp_path / "ran"
    content = [_Runs(function, f"touch {trace}"), *_content()]
    path = _write(tmp_path / "c.pickle", content, protocol=protocol)
    with pytest.raises(
        FileError, match=r"c\.pickle: holds something other than plain numbers .* nothing in it was run"
    ):
        read_camera(path)
    assert not trace.exists()


def test_a_forbidden_name_stays_on_one_line(tmp_path: Path) -> None:
    (tmp_path / "c.pickle").write_bytes(b"\x80\x04\x8c\x04os\nx\x8c\x06system\x93.")
    with pytest.raises(FileError, match="was not loaded") as caught:
        read_camera(tmp_path / "c.pickle")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "content",
    [
        b"cos\nsystem\n(S'true'\ntR.",
        b"(S'true'\nios\nsystem\n.",
        b"\x80\x04\x8c\x05numpy\x8c\x0cndarray.dump\x93.",
        b"c_codecs\nencode\n(V\nS'rot13'\ntR.",
        # BUILD: sets attributes of what is on the stack, here of a permitted name
        b"c_codecs\nencode\n(N(dS'__defaults__'\n(I1\ntstb.",
        b"cnumpy\ndtype\n(dS'x'\nI1\nsb.",
    ],
    ids=["GLOBAL", "INST", "dotted name", "codec", "BUILD function", "BUILD class"],
)
def test_hand_written_attack_is_refused(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "c.pickle").write_bytes(content)
    with pytest.raises(FileError, match="something other than plain numbers"):
        read_camera(tmp_path / "c.pickle")


@pytest.mark.parametrize(
    "array",
    [
        np.array([[None] * 3] * 3, dtype=object),
        np.zeros((3, 3), dtype=[("a", "f8")]),
        np.array([["a"] * 3] * 3),
        np.zeros((3, 3), dtype=complex),
        np.zeros((3, 3), dtype="M8[s]"),
        np.ma.masked_array(np.eye(3)),
    ],
    ids=["object", "fields", "text", "complex", "time", "subclass"],
)
def test_array_of_anything_but_numbers_is_refused(tmp_path: Path, array: object) -> None:
    with pytest.raises(FileError, match="something other than plain numbers"):
        read_camera(_write(tmp_path / "c.pickle", _content(intrinsic=array)))


def test_few_bytes_cannot_reserve_much_memory(tmp_path: Path) -> None:
    attacks = {
        "memo": b"\x80\x02]r\xff\xff\xff\xff.",
        "array": b"cnumpy.core.multiarray\n_reconstruct\n(cnumpy\nndarray\n(L99999999999999L\ntS'b'\ntR.",
        "text": b"\x80\x04\x8d\xff\xff\xff\xff\xff\xff\xff\x7f.",
    }
    for name, content in attacks.items():
        (tmp_path / name).write_bytes(content)
        with pytest.raises(FileError, match="calibration"):
            read_camera(tmp_path / name)


def test_large_file_is_not_loaded(tmp_path: Path) -> None:
    path = _write(tmp_path / "c.pickle", [*_content(), "x" * BYTES_MAX])
    with pytest.raises(FileError, match="too large for a calibration"):
        read_camera(path)


def test_shape_that_its_bytes_do_not_fill_is_an_error(tmp_path: Path) -> None:
    path = _write(tmp_path / "c.pickle", _content())
    path.write_bytes(path.read_bytes().replace(b"K\x03K\x03\x86", b"K\x03K\x04\x86"))
    with pytest.raises(FileError, match="no complete calibration"):
        read_camera(path)


def test_every_truncation_is_a_file_error(tmp_path: Path) -> None:
    content = pickle.dumps(_content(), protocol=2)
    path = tmp_path / "c.pickle"
    for length in range(0, len(content), 7):
        path.write_bytes(content[:length])
        with pytest.raises(FileError):
            read_camera(path)


def test_random_damage_is_a_file_error_or_a_camera(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    whole = np.frombuffer(write_calibration(tmp_path / "c.pickle", CAMERA).read_bytes(), dtype=np.uint8)
    path = tmp_path / "damaged.pickle"
    errors = 0
    for _ in range(300):
        damaged = whole.copy()
        damaged[rng.integers(len(damaged), size=3)] = rng.integers(256, size=3)
        path.write_bytes(damaged.tobytes())
        try:
            read_camera(path)
        except FileError:
            errors += 1
    assert errors > 100


_NAN = np.full((3, 3), np.nan)


@pytest.mark.parametrize(
    ("change", "problem"),
    [
        ({"intrinsic": _NAN}, "intrinsic must be finite"),
        ({"rvec": _NAN}, "rotation must be finite"),
        ({"tvec": _NAN[:1].T}, "translation must be finite"),
        ({"intrinsic": np.eye(4)}, r"intrinsic must have shape \(3, 3\), got \(4, 4\)"),
        ({"intrinsic": -np.eye(3)}, "positive focal lengths"),
        ({"rvec": np.array([0.1, 0.2, 0.3])}, r"rotation must have shape \(3, 3\)"),
        ({"rvec": np.eye(3) * 2}, "must be a .* rotation matrix"),
        ({"rvec": np.diag([1, 1, -1.0])}, "must be a .* rotation matrix"),
        ({"tvec": np.zeros(4)}, r"translation must have shape \(3,\)"),
        ({"tvec": None}, "no usable calibration"),
        ({"tvec": "abc"}, "no usable calibration"),
        ({"intrinsic": [[1, 2], [3]]}, "no usable calibration"),
        ({"intrinsic": {}}, "no usable calibration"),
        ({"intrinsic": [CAMERA.intrinsic]}, "no usable calibration"),
    ],
)
def test_numbers_that_are_no_camera_are_named(tmp_path: Path, change: dict[str, object], problem: str) -> None:
    path = _write(tmp_path / "c.pickle", _content(**change))
    with pytest.raises(FileError, match=rf"c\.pickle: .*{problem}"):
        read_camera(path)


@pytest.mark.parametrize(
    "content",
    [[], {}, 3, None, [{}, {}], [[], []], [{"rgb": 1}], [{"ir1": 1}, {"ir1": 2}], [{"rgb": 1}, {"rgb": None}], "ab"],
    ids=str,
)
def test_other_structure_is_no_calibration(tmp_path: Path, content: object) -> None:
    with pytest.raises(FileError, match="is no calibration"):
        read_camera(_write(tmp_path / "c.pickle", content))


def test_camera_without_extrinsics_is_an_error_that_says_so(tmp_path: Path) -> None:
    path = _write(tmp_path / "c.pickle", [_content()[0], None])
    with pytest.raises(FileError, match="has no extrinsics"):
        read_camera(path)


def test_absent_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(FileError, match=r"c\.pickle: the calibration cannot be read"):
        read_camera(tmp_path / "c.pickle")


def test_real_calibrations_reproduce_their_own_projection_matrices(real_dataset_root: Path) -> None:
    # reading with pickle itself is safe here: the files are known
    for view in ("view1", "view2", "view3"):
        path = real_dataset_root / view / "calib" / "000618.pickle"
        with path.open("rb") as file:
            expected = pickle.load(file, encoding="latin1")[1]["rgb"]["projMatrix"]
        np.testing.assert_allclose(read_camera(path).projection, expected, rtol=1e-6, atol=1e-6)
    with pytest.raises(FileError, match="has no extrinsics"):
        read_camera(real_dataset_root / "view4" / "calib" / "000618.pickle")


def _scaled_translation(factor: float, **more: object) -> list[Any]:
    return _content(tvec=CAMERA.translation[:, None] * factor, **more)


@pytest.mark.parametrize(("factor", "unit"), [(1000, "mm"), (100, "cm"), (1000.0 * np.float32(1), "mm")])
def test_translation_in_another_unit_is_taken_for_what_it_is(tmp_path: Path, factor: float, unit: str) -> None:
    found = read_calibration(_write(tmp_path / "c.pickle", _scaled_translation(factor)))
    np.testing.assert_allclose(found.camera.projection, CAMERA.projection, rtol=1e-6)
    [note] = found.notes
    assert f"was taken for {unit}, which puts the camera 1." in note
    assert flags_of(found.notes) == ("unit-assumed",)


@pytest.mark.parametrize("ends", [b"\r\n", b"\r"])
@pytest.mark.parametrize(("factor", "unit"), [(100, "cm"), (1000, "mm")])
def test_another_unit_and_other_line_ends_together_are_both_noted(
    tmp_path: Path, factor: float, unit: str, ends: bytes
) -> None:
    content = pickle.dumps(_scaled_translation(factor), protocol=0)
    (tmp_path / "c.pickle").write_bytes(content.replace(b"\n", ends))
    found = read_calibration(tmp_path / "c.pickle")
    np.testing.assert_allclose(found.camera.translation, CAMERA.translation)
    assert [part in note for part, note in zip(("line ends", unit), found.notes, strict=True)] == [True, True]


@pytest.mark.parametrize("factor", [1, 0.5, 4, 1e6, 1e200])
def test_translation_that_may_be_metres_or_can_be_nothing_stays(tmp_path: Path, factor: float) -> None:
    found = read_calibration(_write(tmp_path / "c.pickle", _scaled_translation(factor)))
    np.testing.assert_allclose(found.camera.translation, CAMERA.translation * factor)
    assert found.notes == ()


_PLAIN = [
    {"rgb": CAMERA.intrinsic.tolist()},
    {"rgb": {"rvec": CAMERA.rotation.tolist(), "tvec": CAMERA.translation.tolist(), "by": "A\rB\nC"}},
]


@pytest.mark.parametrize("change", [(b"\n", b"\r\n"), (b"\n", b"\r"), (b"", b"\xef\xbb\xbf")])
@pytest.mark.parametrize("content", ["dataset's", "lists"])
def test_text_pickle_with_other_line_ends_is_read(tmp_path: Path, change: tuple[bytes, bytes], content: str) -> None:
    path = tmp_path / "c.pickle"
    written = pickle.dumps(_PLAIN, 0) if content == "lists" else write_calibration(path, CAMERA).read_bytes()
    path.write_bytes(written.replace(*change, -1 if change[0] else 1))
    found = read_calibration(path)
    np.testing.assert_array_equal(found.camera.projection, CAMERA.projection)
    assert "line ends were changed" in found.notes[0]
    assert flags_of(found.notes) == ()


def test_binary_pickle_with_other_line_ends_is_named(tmp_path: Path) -> None:
    path = _write(tmp_path / "c.pickle", [*_content(), "\n"], protocol=4)
    path.write_bytes(path.read_bytes().replace(b"\n", b"\r\n"))
    with pytest.raises(FileError, match="its line ends may have been changed"):
        read_camera(path)


def _nested_tuples(depth: int) -> bytes:
    """Tuples of twice the same tuple, the outermost as a key."""
    return b"\x80\x02}N" + b"2\x86" * depth + b"Ns."


def _shared_lists(depth: int) -> bytes:
    """A calibration whose intrinsics are lists of twice the same list."""
    item = b"]K\x01a" + b"".join(b"q%c](h%ch%ce" % (place, place, place) for place in range(depth))
    rest = b"}U\x03rgb}(U\x04rvech\x01U\x04tvech\x01us"
    return b"\x80\x02]q\xff(}U\x03rgb" + item + b"s" + rest + b"e."


_TIMES = b"c_codecs\nencode\nq\x00X" + (900_000).to_bytes(4, "little") + b"a" * 900_000 + b"\x85q\x01"
_ATTACKS = {
    "tuples as a key": _nested_tuples(60),
    "tuples called": b"\x80\x02}N" + b"2\x86" * 60 + b"NR.",
    "tuples as an encoding": b"\x80\x02c_codecs\nencode\nX\x01\x00\x00\x00aN" + b"2\x86" * 60 + b"\x86R.",
    "tuples as a type": b"\x80\x02cnumpy\ndtype\nN" + b"2\x86" * 60 + b"\x85R.",
    "tuples in DICT": b"\x80\x02(N" + b"2\x86" * 60 + b"Nd.",
    "tuples in a set": b"\x80\x04\x8f(N" + b"2\x86" * 60 + b"\x90.",
    "shared lists": _shared_lists(60),
    "bytearray of 3 GiB": b"\x80\x05\x96" + (3 * 2**30).to_bytes(8, "little") + b".",
    "list of bytes": b"\x80\x04B"
    + (50_000).to_bytes(4, "little")
    + b"a" * 50_000
    + b"\x85q\x00c__builtin__\nlist\nh\x00R.",
    "text encoded again and again": b"\x80\x02" + _TIMES + b"h\x00h\x01R" * 100 + b".",
    "huge shape": b"\x80\x02cnumpy.core.multiarray\nscalar\n(cnumpy\ndtype\n(U\x02f8K\x00K\x01tR\x8a\xff"
    + b"\x7f" * 255
    + b"tR.",
    "instructions": b"\x80\x02" + b"N0" * 400_000 + b"N.",
    "pairs": b"\x80\x02ccollections\nOrderedDict\n](]((N" + b"2\x86" * 60 + b"eee\x85R.",
    "deep lists": b"\x80\x02" + b"]" * 4000 + b"a" * 3999 + b".",
}


@pytest.mark.parametrize("name", _ATTACKS)
def test_small_file_cannot_cost_much(tmp_path: Path, name: str) -> None:
    path = tmp_path / "c.pickle"
    path.write_bytes(_ATTACKS[name])
    began_s, began = time.perf_counter(), resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    with pytest.raises(FileError) as caught:
        read_camera(path)
    assert time.perf_counter() - began_s < 2
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - began < 100_000, "kB"
    assert "\n" not in str(caught.value)
