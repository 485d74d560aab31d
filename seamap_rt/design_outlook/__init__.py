"""What a design is likely to see, at once: a model beside the simulation, never sold as one.

Strips of random sea, one along each of sixteen looks, are lit by an exact horizon. The echo of what is lit has the mean
of the scene's measured model and goes through the link budget; what a cell's height then misses is the least error that
any linear filter of such echoes leaves. Cells are scored as those of a run (`seamap_rt.measured`), so that the fully
measured radius and the reach mean the same. A boat's motion leans the beam, lifts the antennas and is measured with
errors (`motion`). It knows no objects and no time.
"""

from .model import Outlook, estimate_outlook, outlook

__all__ = ["Outlook", "estimate_outlook", "outlook"]
