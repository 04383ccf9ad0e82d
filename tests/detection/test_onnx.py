"""A detector in ONNX format, run by the real runtime."""

import numpy as np
import pytest

from corsmal.detection.onnx import OnnxDetector, open_detector
from corsmal.errors import ArgumentError, FileError

onnx = pytest.importorskip("onnx", reason="makes the networks of these tests")
pytest.importorskip("onnxruntime", reason="needs the extra exchange")

HEIGHT, WIDTH = 8, 12


def write_network(path, *, batch=False, outputs=4):
    """One cup of fixed box; its mask is where the picture's first channel is bright, its score that of pixel (0, 0)."""
    helper, kinds = onnx.helper, onnx.TensorProto
    shape = [1, 3, HEIGHT, WIDTH] if batch else [3, HEIGHT, WIDTH]
    constants = {
        "boxes": np.array([[2, 1, 9, 6]], dtype=np.float32),
        "labels": np.array([47], dtype=np.int64),
        "channel": np.array([0], dtype=np.int64),
        "mask_shape": np.array([1, 1, HEIGHT, WIDTH], dtype=np.int64),
        "score_shape": np.array([1], dtype=np.int64),
        "first": np.array(0, dtype=np.int64),
    }
    nodes = [
        helper.make_node("Gather", ["picture", "channel"], ["red"], axis=1 if batch else 0),
        helper.make_node("Reshape", ["red", "mask_shape"], ["masks"]),
        helper.make_node("Gather", ["masks", "first"], ["row"], axis=2),
        helper.make_node("Gather", ["row", "first"], ["pixel"], axis=2),
        helper.make_node("Reshape", ["pixel", "score_shape"], ["scores"]),
        helper.make_node("Identity", ["boxes"], ["found_boxes"]),
        helper.make_node("Identity", ["labels"], ["found_labels"]),
    ]
    results = [
        helper.make_tensor_value_info("found_boxes", kinds.FLOAT, [1, 4]),
        helper.make_tensor_value_info("found_labels", kinds.INT64, [1]),
        helper.make_tensor_value_info("scores", kinds.FLOAT, [1]),
        helper.make_tensor_value_info("masks", kinds.FLOAT, [1, 1, HEIGHT, WIDTH]),
    ]
    graph = helper.make_graph(
        nodes,
        "cup",
        [helper.make_tensor_value_info("picture", kinds.FLOAT, shape)],
        results[:outputs],
        [onnx.numpy_helper.from_array(value, name) for name, value in constants.items()],
    )
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)], ir_version=8)
    onnx.checker.check_model(model)
    onnx.save(model, path)
    return path


@pytest.mark.parametrize("batch", [False, True])
def test_boxes_labels_scores_and_masks_are_those_of_the_network(tmp_path, batch):
    detector = open_detector(write_network(tmp_path / "cup.onnx", batch=batch), device="cpu")
    assert detector.name == "ONNX network, weights cup.onnx"
    frame = np.zeros((HEIGHT, WIDTH, 3), dtype=np.uint8)
    frame[2:6, 3:8, 0] = 255
    frame[0, 0, 0] = 102  # the score: 0.4
    frame[..., 1] = 255  # of another channel
    found, dark = detector.detect([frame, np.zeros_like(frame)])
    assert found.boxes.tolist() == [[2, 1, 9, 6]]
    assert found.labels.tolist() == [47]
    np.testing.assert_allclose(found.scores, [0.4])
    np.testing.assert_array_equal(found.mask(0), frame[..., 0] == 255)
    assert not dark.mask(0).any()


def test_the_digest_is_that_of_the_file(tmp_path):
    first, same = (OnnxDetector(write_network(tmp_path / name), device="cpu") for name in ("a.onnx", "b.onnx"))
    other = OnnxDetector(write_network(tmp_path / "c.onnx", batch=True), device="cpu")
    assert first.digest == same.digest != other.digest


def test_what_is_no_such_network_is_refused(tmp_path):
    with pytest.raises(ArgumentError, match="--weights"):
        open_detector()
    with pytest.raises(FileError, match="cannot be read"):
        OnnxDetector(tmp_path / "absent.onnx")
    (tmp_path / "text.onnx").write_text("nothing", encoding="utf-8")
    with pytest.raises(FileError, match="is no network in ONNX format"):
        OnnxDetector(tmp_path / "text.onnx")
    with pytest.raises(FileError, match="1 inputs and 3 outputs, expected 1 and 4"):
        OnnxDetector(write_network(tmp_path / "three.onnx", outputs=3))
