"""A nonlinear sea by the high-order spectral method (Dommermuth & Yue 1987; West et al. 1987).

The state is the surface η and the potential φs at it, both on a periodic rectangle over water of one depth. What moves
them is expanded in the steepness to an order of 1 (linear) to 5: order 2 holds sharp crests and flat troughs and the
waves that two waves bind, order 3 also that steep waves run faster and that groups grow unstable (Benjamin & Feir).

    basin         the rectangle, its waves, and FFTs between waves and points
    rates         the nonlinear rates to an order, de-aliased; they conserve their energy exactly
    evolution     time steps: linear waves exactly, the rest by Runge–Kutta; the slow beginning (Dommermuth 2000)
    breaking      the low-pass filter by which breaking takes energy out (Xiao et al. 2013)
    linear_start  a scene's linear waves as the beginning
    plan          spacing, time step, duration of the beginning and memory of a scene's sea

`seamap-rt sea SCENE --nonlinear` writes one. Left out: wind, currents that vary, overturning crests, a bed that is not
level. Evidence: validation/README.md, "A nonlinear sea".
"""

from .basin import Band
from .evolution import Evolution, LowPass, State
from .linear_start import LinearStart
from .plan import Plan
from .rates import Rates

__all__ = ["Band", "Evolution", "LinearStart", "LowPass", "Plan", "Rates", "State"]
