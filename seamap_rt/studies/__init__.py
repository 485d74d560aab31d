"""Loops over whole scenes: how far a radar sees (shadowing), and how its keys affect the maps (trade).

`shadowing` counts what both antennas see of simulated seas, by range, look and antenna height, over seeds, beside the
analytic curves of Smith (1967) and Wagner (1967) with the slopes that the mesh carries. It also gives the mean height
of what is seen, the lengths of shadows and of visible stretches, and for a single sinusoid the exact crest-by-crest
share. It has no objects and no diffraction.

`trade` runs any grid of keys over processes or a dask cluster. Each point has a file of its own; a point that is
refused, fails or is killed is a row with its reason; `resume` runs what is missing, to the same bits. On a cluster:
`trade(…, client=Client("tcp://host:8786"))`, or `--scheduler tcp://host:8786`. A map is usable
over the longest unbroken run of 25 m bins whose rms error is at most a tenth of Hs and of whose cells a third are
seen and have a height (`usable.py` says why). A script whose trade starts processes needs
`if __name__ == "__main__":`, since they import it.

Evidence: validation/models/shadowing.md.
"""

from .choices import outlooks
from .shadowing import shadowing, shadowing_by_cutoff
from .sweep import trade

__all__ = ["outlooks", "shadowing", "shadowing_by_cutoff", "trade"]
