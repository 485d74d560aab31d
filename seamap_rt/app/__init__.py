"""The page: choose waves and radar, see what that is likely to do, run it in a process of its own, look at the results.

`seamap-rt app` serves it. The page's process simulates nothing and loads no ray tracer: a run is the command line in a
process of its own (`jobs`), and what it wrote is read turn by turn from its files (`results`), also while it grows.

`safety` says who may ask and which files may be touched; `draft`, `fields`, `relevance` and `words` are the form
without the page; `prospects` is what a design is likely to do; `pictures`, `figures` and `curves` make what is shown.
`drawing` draws in processes of its own, `child` starts what reads what nobody vouches for: the first reading of an
upload (`checking`). The files whose names end with `_view` are the parts of the page.
"""

from .serving import serve

__all__ = ["serve"]
