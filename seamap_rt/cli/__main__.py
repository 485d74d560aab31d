"""`python -m seamap_rt.cli`."""

import os

from . import main

os.environ.setdefault("COLUMNS", "120")
main()
