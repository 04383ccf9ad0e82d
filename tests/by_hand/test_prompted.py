"""A promptable network in ONNX format, run by the real runtime."""

import numpy as np
import pytest

from corsmal.by_hand import OnnxSegmenter, Prompt, open_segmenter
from corsmal.errors import FileError

onnx = pytest.importorskip("onnx", reason="makes the networks of these tests")
pytest.importorskip("onnxruntime", reason="needs the extra exchange")

SHAPE = (120, 160)
BOX = (50, 30, 110, 100)


def write_segmenter(path, *, inputs=("image", "box", "points", "labels")):
    """Its mask is where the picture's first channel is bright, times the mean of the labels."""
    helper, kinds = onnx.helper, onnx.TensorProto
    shapes = {"image": [1, 3, *SHAPE], "box": [1, 4], "points": [1, None, 2], "labels": [1, None]}
    red = onnx.numpy_helper.from_array(np.array([0], dtype=np.int64), "red")
    nodes = [
        helper.make_node("Gather", ["image", "red"], ["channel"], axis=1),
        helper.make_node("ReduceMean", ["labels"], ["told"], keepdims=0),
        helper.make_node("Mul", ["channel", "told"], ["mask"]),
    ]
    given = [helper.make_tensor_value_info(name, kinds.FLOAT, shapes[name]) for name in inputs]
    result = [helper.make_tensor_value_info("mask", kinds.FLOAT, [1, 1, *SHAPE])]
    graph = helper.make_graph(nodes, "segmenter", given, result, [red])
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)], ir_version=8)
    onnx.save(model, path)
    return path


def test_a_network_answers_image_box_points_and_labels(tmp_path, monkeypatch):
    path = write_segmenter(tmp_path / "segmenter.onnx")
    monkeypatch.setenv("CORSMAL_SEGMENTER", str(path))
    segmenter = open_segmenter()
    image = np.zeros((*SHAPE, 3), dtype=np.uint8)
    image[20:40, 30:60, 0] = 255
    assert segmenter.name == "ONNX network, weights segmenter.onnx"
    assert segmenter.digest == OnnxSegmenter(path).digest
    np.testing.assert_array_equal(segmenter.propose(image, Prompt(BOX)).mask, image[..., 0] == 255)
    # with more strokes beside than on the container the labels' mean falls below a half
    told = segmenter.propose(image, Prompt(BOX, inside=[[(40, 30)]], outside=[[(1, 1), (2, 2)]]))
    assert not told.mask.any()
    assert "Nothing was found" in told.said


def test_a_network_of_another_form_and_a_missing_file_are_refused(tmp_path):
    with pytest.raises(FileError, match="expected image, box, points, labels and one output"):
        OnnxSegmenter(write_segmenter(tmp_path / "a.onnx", inputs=("image", "box", "labels")))
    with pytest.raises(FileError, match="cannot be read"):
        OnnxSegmenter(tmp_path / "missing.onnx")
    (tmp_path / "text.onnx").write_text("no network")
    with pytest.raises(FileError, match="no network in ONNX format"):
        OnnxSegmenter(tmp_path / "text.onnx")
