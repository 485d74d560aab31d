"""What all open pages share (folders, the queue of runs), and what each browser tab has for itself."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from ..io.scenefile import list_shipped
from .jobs import Queue
from .runs import kind_of
from .safety import Roots

if TYPE_CHECKING:
    from ..scene import Scene
    from .draft import Draft

_MOST_TABS = 50


@dataclass
class Tab:
    """What one browser tab is at; it survives a reload."""

    draft: Draft
    pinned: tuple[str, Scene] | None = None  # a design to hold the draft against, with its name
    run: str = ""  # that is looked at
    other: str = ""  # that it is compared with
    trade: str = ""  # that is looked at
    turn: int = 0
    view: str = "heights"
    place: str = "Design"  # of the page


@dataclass
class Desk:
    """The page's own state, one a server."""

    roots: Roots
    queue: Queue
    tabs: dict[str, Tab] = field(default_factory=dict)

    @classmethod
    def of(cls, runs: Path) -> Desk:
        """runs: a folder that is there."""
        shipped = next(iter(list_shipped().values())).parent
        roots = Roots(runs.resolve(), (shipped,))
        return cls(roots, Queue(roots.runs))

    def awaited(self, folder: str) -> bool:
        """Whether results of a folder's name are there, or come; not those of a job that came to nothing."""
        job, path = self.queue.of_folder(folder), self.roots.runs / folder
        return (job is not None and not job.over) or (path.is_dir() and kind_of(path) is not None)

    def tab(self, name: str) -> Tab:
        """Of a browser tab by the name that it gives itself; a new one begins with choppy_sea."""
        from .draft import Draft

        tab = self.tabs.pop(name, None) or Tab(Draft.shipped("choppy_sea", self.roots))
        self.tabs[name] = tab  # the one used last is the last
        while len(self.tabs) > _MOST_TABS:
            self.tabs.pop(next(iter(self.tabs)))
        return tab
