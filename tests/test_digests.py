import itertools
import os
import subprocess
import sys
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pytest

from corsmal.digests import digest, file_fingerprint
from corsmal.errors import ArgumentError, FileError
from corsmal.fields import UNLESS_DEFAULT
from corsmal.parameters import SelectionParameters, ShapeParameters


@dataclass(frozen=True)
class Pair:
    first: object
    second: object


@dataclass(frozen=True)
class OtherPair:
    first: object
    second: object


DIFFERENT = [
    (),
    (None,),
    (0,),
    (0.0,),
    (-0.0,),
    (False,),
    ("",),
    ("0",),
    (b"0",),
    ((),),
    ({},),
    (frozenset(),),
    ("a", "bc"),
    ("ab", "c"),
    (("a",), "bc"),
    (("a", "bc"),),
    ({"a": 1, "b": 2},),
    ({"a": 2, "b": 1},),
    (0.1,),
    (np.nextafter(0.1, 1),),
    (float("nan"),),
    (Pair(1, 2),),
    (OtherPair(1, 2),),
    (Pair(2, 1),),
    (Pair((1,), 2),),
    (np.zeros(3),),
    (np.zeros((3, 1)),),
    (np.zeros(3, dtype=np.float32),),
    (ShapeParameters.paper(),),
    (ShapeParameters.lode(),),
]


def test_different_values_have_different_digests():
    digests = [digest(*parts) for parts in DIFFERENT]
    for (one, first), (other, second) in itertools.combinations(zip(DIFFERENT, digests, strict=True), 2):
        assert first != second, (one, other)


def test_equal_values_have_equal_digests():
    assert digest({"a": 1, "b": 2}) == digest({"b": 2, "a": 1})
    assert digest([1, 2]) == digest((1, 2))
    assert digest(np.int64(3), np.float64(0.5), np.bool_(True)) == digest(3, 0.5, True)
    assert digest(ShapeParameters.paper()) == digest(ShapeParameters())
    assert digest(np.arange(6).reshape(2, 3)) == digest(np.asfortranarray(np.arange(6).reshape(2, 3)))


def test_a_digest_is_the_same_in_another_process():
    code = (
        "from corsmal.digests import *; from corsmal.parameters import *; print(digest(SelectionParameters(), {'a'}))"
    )
    environment = os.environ | {"PYTHONHASHSEED": "77", "PYTHONPATH": str(Path(__file__).resolve().parents[1])}
    other = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, env=environment)
    assert other.stdout.strip() == digest(SelectionParameters(), {"a"})
    assert len(other.stdout.strip()) == 32


@pytest.mark.parametrize("value", [object(), print, Pair, 1j, np.array([object()]), (object(),)])
def test_a_value_without_a_stable_form_is_an_error(value):
    with pytest.raises(ArgumentError, match="parts must be"):
        digest(value)


def test_a_path_stands_for_its_file(tmp_path):
    path = tmp_path / "view1" / "rgb" / "000001.mp4"
    path.parent.mkdir(parents=True)
    path.write_bytes(b"one")
    os.utime(path, ns=(5, 5))
    before = digest(path)
    assert digest(path) == before
    assert file_fingerprint(path) == "3 bytes, 5 ns, view1/rgb/000001.mp4"
    os.utime(path, ns=(6, 6))
    assert digest(path) != before
    path.write_bytes(b"longer")
    os.utime(path, ns=(5, 5))
    assert digest(path) != before


def test_the_same_file_of_another_view_is_another_file(tmp_path):
    paths = [tmp_path / view / "calib" / "000001.pickle" for view in ("view1", "view2")]
    for path in paths:
        path.parent.mkdir(parents=True)
        path.write_bytes(b"one")
        os.utime(path, ns=(5, 5))
    assert digest(paths[0]) != digest(paths[1])


def test_a_moved_dataset_keeps_its_fingerprints(tmp_path):
    path = tmp_path / "here" / "view1" / "rgb" / "000001.mp4"
    path.parent.mkdir(parents=True)
    path.write_bytes(b"one")
    before = file_fingerprint(path)
    (tmp_path / "here").rename(tmp_path / "there")
    assert file_fingerprint(tmp_path / "there" / "view1" / "rgb" / "000001.mp4") == before


def test_an_absent_file_or_a_folder_has_no_fingerprint(tmp_path):
    for path in (tmp_path / "absent", tmp_path):
        with pytest.raises(FileError):
            file_fingerprint(path)


@dataclass(frozen=True)
class Before:
    size: int = 3


def test_a_field_with_a_default_that_means_what_was_before_leaves_the_digest_alone():
    @dataclass(frozen=True)
    class After:
        size: int = 3
        rule: str = field(default="old", metadata=UNLESS_DEFAULT)

    After.__qualname__ = Before.__qualname__
    assert digest(After()) == digest(Before())
    assert digest(After(rule="new")) != digest(Before())
