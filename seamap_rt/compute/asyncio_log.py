"""asyncio's log, without what it says of Zarr's and dask's tasks that are told already: failed, or interrupted."""

from __future__ import annotations

import logging
import traceback


def filter_asyncio_log() -> None:
    """From here on. These libraries do several things beside each other and raise what goes wrong with one of them;
    asyncio tells of the others when they are forgotten, on standard error, beside the line that says it all. So it does
    of those that are left when the process is interrupted."""
    logging.getLogger("asyncio").addFilter(_is_relevant)


def _is_relevant(record: logging.LogRecord) -> bool:
    text = record.getMessage()
    raised = record.exc_info[1] if record.exc_info else None
    where = traceback.walk_tb(raised.__traceback__ if raised else None)
    libraries = type(raised).__module__, text, *(frame.f_code.co_filename for frame, _ in where)
    left = "never retrieved" in text or "was destroyed but it is pending" in text
    return not (left and any(name in said for said in libraries for name in ("zarr", "distributed")))
