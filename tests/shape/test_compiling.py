import json
import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]

PROGRAM = """
import json
from corsmal.parameters import ShapeParameters
from corsmal.shape import agreed_kernels, box_kernels, fit_agreeing, kernels, outline_kernels
from corsmal.shape.compiling import compile_fits
from tests.tiny import silhouette, tiny_cameras

def compiled():
    modules = (agreed_kernels, box_kernels, kernels, outline_kernels)
    loops = {name: each for module in modules for name, each in vars(module).items() if hasattr(each, "signatures")}
    return {name: len(each.signatures) for name, each in loops.items()}

reasons, before = compile_fits(), compiled()
cameras = list(tiny_cameras((1280, 720)).values())
masks = [silhouette(camera, ([0.0, 119.0], [30.5, 49.0]), (0.01, -0.02, 0.03)) for camera in cameras]
for views in (2, 3):
    for preset in (ShapeParameters.paper(), ShapeParameters.tuned()):
        assert fit_agreeing(cameras[:views], masks[:views], preset).ok
print(json.dumps([reasons, before, compiled()]))
"""


def test_no_fit_compiles_anything_after_it():
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    command = [sys.executable, "-c", PROGRAM]
    printed = subprocess.run(command, env=environment, capture_output=True, text=True, check=True).stdout
    reasons, before, after = json.loads(printed)
    assert reasons == {"paper, 2": "", "paper, 3": "", "tuned, 2": "", "tuned, 3": ""}
    assert before == after
    loops = {"first_fitting_radius", "reweighted_agreement", "reach_errors", "ends_of_rows", "middle_of_missing"}
    assert loops <= {name for name, types in before.items() if types}  # what they call is loaded with them
