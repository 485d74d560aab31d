"""The command line of a study, from the names and defaults of its options."""

from __future__ import annotations

import argparse
from pathlib import Path


def options(doc: str | None, **defaults: object) -> argparse.Namespace:
    """What was asked for, by name. A default gives its type; a type alone has the default None; False is a flag; a list
    takes one value or more of its first one's type. doc: the module's own, which names them all."""
    parser = argparse.ArgumentParser(description=doc, formatter_class=argparse.RawDescriptionHelpFormatter)
    for name, default in defaults.items():
        flag = f"--{name.replace('_', '-')}"
        if default is False:
            parser.add_argument(flag, action="store_true")
        elif isinstance(default, type):
            parser.add_argument(flag, type=default)
        elif isinstance(default, list):
            parser.add_argument(flag, type=type(default[0]), nargs="+", default=default)
        else:
            parser.add_argument(flag, type=Path if isinstance(default, Path) else type(default), default=default)
    return parser.parse_args()
