"""The page: choose waves and radar, see what that is likely to do, run it in a process of its own, look at the results.

`seamap-rt app` serves it. The page's process simulates nothing and loads no ray tracer: a run is the command line in a
process of its own (`jobs`), and what it wrote is read turn by turn from its files (`results`), also while it grows.

`safety` says who may ask and which files may be touched; `draft` is the form without the page; `prospects` is what a
design is likely to do. What a person moves, plays or points at is a graph in the browser (`figures`); any other figure
is the report's own, as an image (`widgets`). Drawings have processes of their own (`jobs`); an upload is first read in
another (`uploads`). The files whose names end with `_view` are the places of the page, and `panels` parts of See.
"""

from .serving import serve

__all__ = ["serve"]
