"""The compiled loops of what the sides of views agree on.

They use few of NumPy's functions: compiling those takes longer than all that is written here.
"""

import numba
import numpy as np


@numba.njit(nogil=True, cache=True, error_model="numpy")
def reweighted_agreement(  # type: ignore[no-untyped-def]  # noqa: PLR0917 - compiled code takes no keywords
    sides_mm, seen, heights_mm, along, prior, first_mm, steps, costs, scales_mm, outward, corner, least_weight
):  # pragma: no cover - compiled
    """Radii and axis that the sides of views agree on, see ``corsmal.shape.agreed.agree``.

    Args: sides_mm and seen (V, 2, H); heights_mm (H,); along (V, 2) how much the first side of each view grows with a
    shift of the axis along either direction across it, the second one shrinks as much; prior (4,) what squares of the
    two shifts and slopes of the axis cost; first_mm (H,) radii to begin with; steps (R,) how much more is forgiven in
    each round; costs (R,) of a bend in each, 0 where each height has a radius of its own; scales_mm (1 + V,) the error
    that counts a quarter, and the error at which a view counts half; the others are constants of that module.

    Returns: radii (H,), unknowns (4,), trust (V,) and the summed weights (H,).
    """
    views, _, rows = sides_mm.shape
    radii, unknowns, trust, agreeing = first_mm.copy(), np.zeros(4), np.zeros(views), np.zeros(rows)
    error, weights, held = np.zeros((views, 2, rows)), np.zeros((views, 2, rows)), np.zeros(2 * rows)
    stiffness = np.full(max(rows - 2, 0), costs[0])
    for number in range(len(steps)):
        for v in range(views):
            shift = along[v, 0] * unknowns[0] + along[v, 1] * unknowns[1]
            slope = along[v, 0] * unknowns[2] + along[v, 1] * unknowns[3]
            usual = side_errors(sides_mm[v], seen[v], heights_mm, radii, shift, slope, error[v], held)
            trust[v] = 1 / (usual**2 + scales_mm[1 + v] ** 2)
        weigh(error, seen, trust, scales_mm[0] * steps[number], outward, costs[number] > 0, weights, agreeing)
        least_squares(sides_mm, heights_mm, along, weights, prior, stiffness, least_weight, radii, unknowns)
        for h in range(rows - 2):
            bend = (radii[h + 2] - radii[h + 1]) - (radii[h + 1] - radii[h])
            stiffness[h] = costs[number] / (1 + (bend / (corner * steps[number])) ** 2)
    return radii, unknowns, trust, agreeing


@numba.njit(nogil=True, cache=True, error_model="numpy")
def side_errors(  # type: ignore[no-untyped-def]  # noqa: PLR0917 - compiled code takes no keywords
    sides_mm, seen, heights_mm, radii, shift, slope, error, held
):  # pragma: no cover - compiled
    """The errors of one view's sides into ``error`` (2, H), and their usual size; ``held`` (2·H,) is overwritten."""
    count = 0
    for s in range(2):
        for h in range(len(radii)):
            if seen[s, h]:
                moved = shift + slope * heights_mm[h]
                error[s, h] = sides_mm[s, h] - radii[h] - (moved if s == 0 else -moved)
                held[count] = abs(error[s, h])
                count += 1
    return median(held[:count])


@numba.njit(nogil=True, cache=True, error_model="numpy")
def weigh(  # type: ignore[no-untyped-def]  # noqa: PLR0917 - compiled code takes no keywords
    error, seen, trust, scale_mm, outward, is_shared, weights, agreeing
):  # pragma: no cover - compiled
    """How much each side counts into ``weights`` (V, 2, H), and their sums into ``agreeing`` (H,).

    ``trust`` (V,) becomes 1 for the best view. Where ``is_shared``, a height counts as its sides agree.
    """
    views, _, rows = error.shape
    best, most = trust.max(), 1e-9
    for h in range(rows):
        agreeing[h] = 0.0
    for v in range(views):
        trust[v] /= best
        for s in range(2):
            for h in range(rows):
                if seen[v, s, h]:
                    scale = scale_mm * (1.0 if error[v, s, h] < 0 else outward)
                    weights[v, s, h] = trust[v] / (1 + (error[v, s, h] / scale) ** 2) ** 2
                    agreeing[h] += weights[v, s, h]
    for h in range(rows):
        most = max(most, agreeing[h])
    for v in range(views if is_shared else 0):
        for s in range(2):
            for h in range(rows):
                weights[v, s, h] *= agreeing[h] / most


@numba.njit(nogil=True, cache=True, error_model="numpy")
def least_squares(  # type: ignore[no-untyped-def]  # noqa: PLR0917 - compiled code takes no keywords
    sides_mm, heights_mm, along, weights, prior, stiffness, least_weight, radii, unknowns
):  # pragma: no cover - compiled
    """The least weighted squares of errors and of second differences of the radii, into radii (H,) and unknowns (4,).

    The radii are eliminated: for given unknowns they solve a system of five bands. Args are as above; ``weights``
    (V, 2, H) and ``stiffness`` (H - 2,) are those of one round. A shift and a slope make the first side of a view
    larger and the second smaller by as much, so that sums of powers of the heights are all that is needed of a view.
    """
    views, _, rows = sides_mm.shape
    bands, right = second_difference_bands(stiffness), np.zeros((rows, 5))
    normal, wanted, powers, moments = np.zeros((4, 4)), np.zeros(4), np.zeros(3), np.zeros(2)
    for v in range(views):
        powers[0] = powers[1] = powers[2] = moments[0] = moments[1] = 0.0
        for h in range(rows):
            first, second, height = weights[v, 0, h], weights[v, 1, h], heights_mm[h]
            both, apart = first + second, first - second
            moment = first * sides_mm[v, 0, h] - second * sides_mm[v, 1, h]
            bands[2, h] += both
            right[h, 0] += first * sides_mm[v, 0, h] + second * sides_mm[v, 1, h]
            right[h, 1] += along[v, 0] * apart
            right[h, 2] += along[v, 1] * apart
            powers[0] += both
            powers[1] += both * height
            powers[2] += both * height * height
            moments[0] += moment
            moments[1] += moment * height
        for u in range(4):
            wanted[u] += along[v, u % 2] * moments[u // 2]
            for w in range(4):
                normal[u, w] += along[v, u % 2] * along[v, w % 2] * powers[u // 2 + w // 2]
    for h in range(rows):
        bands[2, h] += least_weight
        right[h, 3], right[h, 4] = heights_mm[h] * right[h, 1], heights_mm[h] * right[h, 2]
    crossed = right[:, 1:].copy()
    solve_bands(bands, right)
    for u in range(4):
        normal[u, u] += prior[u]
        for h in range(rows):
            wanted[u] -= crossed[h, u] * right[h, 0]
            for w in range(4):
                normal[u, w] -= crossed[h, u] * right[h, 1 + w]
    solve(normal, wanted)
    for u in range(4):
        unknowns[u] = wanted[u]
    for h in range(rows):
        radii[h] = right[h, 0]
        for u in range(4):
            radii[h] -= right[h, 1 + u] * unknowns[u]


@numba.njit(nogil=True, cache=True, error_model="numpy")
def reweighted_smoothing(  # type: ignore[no-untyped-def]  # noqa: PLR0917 - compiled code takes no keywords
    radii_mm, believed, tolerances, stiffness, corner, outlier_mm
):  # pragma: no cover - compiled
    """The radii (H,) of ``corsmal.shape.profiles.smooth_profile``, from what is known and how much it is believed.

    Args: radii_mm and believed (H,); tolerances (R,) how much larger corners and outliers must be in each round; the
    others are constants of that module.
    """
    rows = len(radii_mm)
    trust, bends, found = believed.copy(), np.full(rows - 2, stiffness), np.zeros((rows, 1))
    for tolerance in tolerances:
        bands = second_difference_bands(bends)
        for h in range(rows):
            bands[2, h] += trust[h] + 1e-9
            found[h, 0] = trust[h] * radii_mm[h]
        solve_bands(bands, found)
        for h in range(rows):
            trust[h] = believed[h] / (1 + ((radii_mm[h] - found[h, 0]) / (outlier_mm * tolerance)) ** 2) ** 2
            if h < rows - 2:
                bend = (found[h + 2, 0] - found[h + 1, 0]) - (found[h + 1, 0] - found[h, 0])
                bends[h] = stiffness / (1 + (bend / (corner * tolerance)) ** 2)
    return found[:, 0]


@numba.njit(nogil=True, cache=True, error_model="numpy")
def second_difference_bands(stiffness):  # type: ignore[no-untyped-def]  # pragma: no cover - compiled
    """The matrix of Σ stiffness·(second difference of x)², (n,) for x of n + 2, upper half, see ``solve_bands``."""
    bands = np.zeros((3, len(stiffness) + 2))
    for row, cost in enumerate(stiffness):
        bands[2, row] += cost
        bands[2, row + 1] += 4 * cost
        bands[2, row + 2] += cost
        bands[1, row + 1] -= 2 * cost
        bands[1, row + 2] -= 2 * cost
        bands[0, row + 2] += cost
    return bands


@numba.njit(nogil=True, cache=True, error_model="numpy")
def solve_bands(bands, right):  # type: ignore[no-untyped-def]  # pragma: no cover - compiled
    """Solve a symmetric positive definite system of five bands by their Cholesky decomposition.

    Args: bands (3, n) of the upper half, the diagonal last; right (n, m). Both are overwritten, ``right`` by what is
    sought.
    """
    rows, columns = right.shape
    for h in range(rows):
        far = bands[0, h] / bands[2, h - 2] if h > 1 else 0.0
        near = (bands[1, h] - (far * bands[1, h - 1] if h > 1 else 0.0)) / bands[2, h - 1] if h else 0.0
        bands[0, h], bands[1, h], bands[2, h] = far, near, np.sqrt(bands[2, h] - far * far - near * near)
        for m in range(columns):
            value = right[h, m]
            value -= (far * right[h - 2, m] if h > 1 else 0.0) + (near * right[h - 1, m] if h else 0.0)
            right[h, m] = value / bands[2, h]
    for h in range(rows - 1, -1, -1):
        for m in range(columns):
            value = right[h, m]
            value -= bands[1, h + 1] * right[h + 1, m] if h + 1 < rows else 0.0
            value -= bands[0, h + 2] * right[h + 2, m] if h + 2 < rows else 0.0
            right[h, m] = value / bands[2, h]


@numba.njit(nogil=True, cache=True, error_model="numpy")
def solve(matrix, right):  # type: ignore[no-untyped-def]  # pragma: no cover - compiled
    """Solve a symmetric positive definite system, matrix (n, n) and right (n,); both are overwritten."""
    for row in range(len(right)):
        for column in range(row + 1):
            value = matrix[row, column]
            for k in range(column):
                value -= matrix[row, k] * matrix[column, k]
            matrix[row, column] = np.sqrt(value) if column == row else value / matrix[column, column]
        for k in range(row):
            right[row] -= matrix[row, k] * right[k]
        right[row] /= matrix[row, row]
    for row in range(len(right) - 1, -1, -1):
        for k in range(row + 1, len(right)):
            right[row] -= matrix[k, row] * right[k]
        right[row] /= matrix[row, row]


@numba.njit(nogil=True, cache=True, error_model="numpy")
def median(values):  # type: ignore[no-untyped-def]  # pragma: no cover - compiled
    """The median of numbers, 0 of none; they are put into another order (Hoare's selection)."""
    count = len(values)
    if count == 0:
        return 0.0
    middle, low, high = count // 2, 0, count - 1
    while low < high:
        pivot, left, right = values[(low + high) // 2], low, high
        while left <= right:
            while values[left] < pivot:
                left += 1
            while values[right] > pivot:
                right -= 1
            if left <= right:
                values[left], values[right] = values[right], values[left]
                left, right = left + 1, right - 1
        if middle <= right:
            high = right
        elif middle >= left:
            low = left
        else:
            break
    upper = values[middle]
    if count % 2:
        return upper
    lower = values[0]
    for index in range(1, middle):
        lower = max(lower, values[index])
    return (lower + upper) / 2
