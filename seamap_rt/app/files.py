"""The files that the page gives away: products of runs, by name, from folders below the runs."""

from __future__ import annotations

from typing import TYPE_CHECKING
from urllib.parse import quote

from fastapi import FastAPI
from fastapi.responses import FileResponse, PlainTextResponse, Response

from ..errors import InputError

if TYPE_CHECKING:
    from .desk import Desk

PRODUCTS = {  # that may be downloaded, with their types; a page of ours is shown, the others are saved
    "report.html": "text/html; charset=utf-8",
    "retrieval.html": "text/html; charset=utf-8",
    "trade.html": "text/html; charset=utf-8",
    "shadowing.html": "text/html; charset=utf-8",
    "maps.nc": "application/x-netcdf",
    "truth.nc": "application/x-netcdf",
    "prediction.nc": "application/x-netcdf",
    "gauges.nc": "application/x-netcdf",
    "trade.nc": "application/x-netcdf",
    "shadowing.nc": "application/x-netcdf",
    "trade.csv": "text/csv; charset=utf-8",
    "shadowing.csv": "text/csv; charset=utf-8",
    "metrics.json": "application/json",
    "scene.toml": "text/plain; charset=utf-8",
    "sea.nc": "application/x-netcdf",
    "statistics.txt": "text/plain; charset=utf-8",
    "from_mast.png": "image/png",
    "sea_surface.png": "image/png",
    "directional_spectrum.png": "image/png",
    "sea.gif": "image/gif",
}


def give_files(app: FastAPI, desk: Desk) -> None:
    """Adds the address `/files/RUN/NAME`."""

    @app.get("/files/{path:path}")
    def give(path: str) -> Response:
        run, _, name = path.rpartition("/")
        if name not in PRODUCTS or not run:
            return PlainTextResponse(f"no such product; there are {', '.join(PRODUCTS)}\n", 404)
        try:
            file = desk.roots.run(run) / name
        except InputError as refusal:
            return PlainTextResponse(f"{refusal}\n", 404)
        if not file.is_file() or not desk.roots.holds(file):
            return PlainTextResponse(f"{name}: not there yet\n", 404)
        kind = PRODUCTS[name]
        shown = kind.startswith("text/html")
        headers = (
            {
                "content-security-policy": "sandbox allow-scripts; default-src 'none'; img-src data:; "
                "style-src 'unsafe-inline'; script-src 'unsafe-inline'"
            }
            if shown
            else {}
        )
        disposition = "inline" if shown else "attachment"
        saved = f"{run.replace('/', '_')}_{name}"
        return FileResponse(
            file, media_type=kind, filename=saved, content_disposition_type=disposition, headers=headers
        )


def address(run: str, name: str) -> str:
    """Of a product of a run, by the run's name."""
    return f"/files/{quote(run)}/{name}"


def products_of(folder) -> list[str]:
    """What of a folder may be downloaded."""
    return [name for name in PRODUCTS if (folder / name).is_file()]
