"""A nonlinear sea by the high-order spectral method (Dommermuth & Yue 1987; West et al. 1987).

The state is the surface η and the potential φs at it, both on a periodic rectangle over water of one depth. What moves
them is expanded in the steepness to an order of 1 (linear) to 5: order 2 holds sharp crests and flat troughs and the
waves that two waves bind, order 3 also that steep waves run faster and that groups grow unstable (Benjamin & Feir).

    rates       the rectangle, its waves, FFTs between waves and points; the nonlinear rates to an order, de-aliased,
                which conserve their energy exactly
    evolution   time steps: linear waves exactly, the rest by Runge–Kutta; the slow beginning (Dommermuth 2000); the
                low-pass filter by which breaking takes energy out (Xiao et al. 2013)
    plan        spacing, time step, duration of the beginning and memory of a scene's sea, which begins as linear waves

`seamap-rt sea SCENE --nonlinear` writes one. Left out: wind, currents that vary, overturning crests, a bed that is not
level. Evidence: validation/models/sea.md.
"""

from .evolution import Evolution, LowPass, State
from .plan import LinearStart, Plan
from .rates import Band, Rates

__all__ = ["Band", "Evolution", "LinearStart", "LowPass", "Plan", "Rates", "State"]
