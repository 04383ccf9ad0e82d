"""The error that a fit is predicted to have, from what can be seen of it: nobody knows the truth in a new recording."""

from collections.abc import Mapping

import numpy as np

ROUND = {"constant": 1.13, "unexplained": 11.5, "ends": 0.85, "beyond": 0.14, "coarse": 2.4, "pair": 0.38}
BOX = {"constant": -0.06, "unexplained": 24.7, "ends": 2.4, "coarse": 6.8, "pair": 0.55}
"""The logarithm of the error in % is the constant and so many times each number of the evidence, as 467 fits to
detected masks in 30 recordings of the demo have it (seeds 5 and 11; least squares, no weight negative).

``unexplained``: share of the masks that the silhouettes do not cover, mean of the views. ``ends``: how far the views
disagree on base and rim, of the height. ``beyond``: pixels of the silhouettes outside the masks, as a share of the
masks. ``coarse``: what a pixel spans, of the mean radius. ``pair``: 1 where only two views show it.
"""

ERROR_PCT = (0.5, 100.0)


def predicted_error_pct(evidence: Mapping[str, float], *, is_box: bool) -> float:
    """The mean error of the four quantities that a fit is predicted to have, in %."""
    weights = BOX if is_box else ROUND
    exponent = sum(weight * (1.0 if name == "constant" else evidence[name]) for name, weight in weights.items())
    return float(np.clip(np.exp(exponent), *ERROR_PCT))
