"""The root of a function of one number, for what the checks of a scene ask: scipy.optimize takes longer to load than
all of them to be made.

Brent, Algorithms for Minimization without Derivatives (1973), chapter 4: interpolation, with bisections that keep the
root in its bracket. A test holds it to SciPy's, bit for bit.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable

_MOST = 100  # steps; bisections alone take some 50
_ROUNDING = 4.0 * sys.float_info.epsilon


def bracketed_root(function: Callable[[float], float], low: float, high: float, tolerance: float = 1e-12) -> float:
    """Where a function crosses 0 between two numbers, to half the tolerance. Raises ValueError where its signs at both
    are the same, or it is so flat that there is no telling."""
    before, best = low, high  # the last two places; across: the nearest with the other sign
    f_before, f_best = function(before), function(best)
    if f_before * f_best > 0.0:
        raise ValueError(f"a function must change its sign between {low:g} and {high:g}")
    across, f_across = before, f_before
    step = last = best - before
    for _ in range(_MOST):
        if abs(f_across) < abs(f_best):
            before, best, across = best, across, best
            f_before, f_best, f_across = f_best, f_across, f_best
        enough, half = 0.5 * (tolerance + _ROUNDING * abs(best)), 0.5 * (across - best)
        if f_best == 0.0 or abs(half) < enough:
            return best
        last, step, earlier = half, half, (last, step)
        if abs(earlier[0]) > enough and abs(f_best) < abs(f_before):
            rise = (f_before - f_best) / (before - best)
            guess = -f_best * (best - before) / (f_best - f_before)
            if before != across:
                beyond = (f_across - f_best) / (across - best)
                guess = -f_best * (f_across * beyond - f_before * rise) / (beyond * rise * (f_across - f_before))
            if 2.0 * abs(guess) < min(abs(earlier[0]), 3.0 * abs(half) - enough):
                last, step = earlier[1], guess
        before, f_before = best, f_best
        best += step if abs(step) > enough else math.copysign(enough, half)
        f_best = function(best)
        if f_best * f_across > 0.0:
            across, f_across = before, f_before
            step = last = best - before
    raise ValueError(f"a root between {low:g} and {high:g} was not reached")
