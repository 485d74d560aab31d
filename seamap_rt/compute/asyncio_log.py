"""asyncio's log, without the exceptions of Zarr's and dask's tasks that another task has raised already."""

from __future__ import annotations

import logging


def filter_asyncio_log() -> None:
    """From here on. These libraries do several things beside each other and raise what goes wrong with one of them;
    asyncio tells of the others when they are forgotten, on standard error, beside the line that says it all."""
    logging.getLogger("asyncio").addFilter(_is_relevant)


def _is_relevant(record: logging.LogRecord) -> bool:
    text = record.getMessage()
    raised = record.exc_info[1] if record.exc_info else None
    libraries = type(raised).__module__, text
    return not (
        "never retrieved" in text and any(name in said for said in libraries for name in ("zarr", "distributed"))
    )
