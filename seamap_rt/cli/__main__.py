"""`python -m seamap_rt.cli`."""

import os

from . import main

os.environ.setdefault("COLUMNS", "120")  # else lines are broken at 80 where no terminal says how wide it is
main()
