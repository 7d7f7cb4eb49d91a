"""A page as a list of parts in one template: an HTML file that fetches nothing.

Pages of runs, choices, comparisons and advice are such lists. A part is a template of `assets/` and
its values; the charts of all parts are read by one script.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from markupsafe import Markup

from rolling import __version__
from rolling.figures.picture import Picture
from rolling.kinds.page_parts import Part
from rolling.report import text
from rolling.report.chart_svg import chart_svg
from rolling.report.charts import Chart, chart_of
from rolling.report.machine_drawing import MachineDrawing
from rolling.report.templates import environment, joined_script

LARGEST_CSV = 20_000  # bytes of a table on the page; of longer ones it has the curves as drawn
STYLES = ("report.css", "chart.css", "parts.css")


class ChartList:
    """The charts of a page in the order in which its parts show them."""

    def __init__(self) -> None:
        self.shown = list[Chart]()

    def add(self, chart: Chart) -> int:
        """Show a chart and return its number."""
        self.shown.append(chart)
        return len(self.shown) - 1

    def sharing(self, chart: Chart) -> str:
        """Return the numbers of the runs that have the chart of a run."""
        return str(chart["run"])


def exhibit(picture: Picture) -> Chart:
    """Read a picture as a chart with its table."""
    chart = chart_of(picture)
    table = picture.file("csv")
    if table is not None and len(table) <= LARGEST_CSV:
        chart["csv"] = table.decode()
    return chart


@dataclass(frozen=True, kw_only=True)
class PageOfParts:
    """A page, before it is written.

    Parameters
    ----------
    title : str
        What it is about; of a run, what rolls on what.
    noise : str
        Words for the title of the window. Default: contact noise.
    notice : str
        What a reader has to know first. Default: nothing.
    unsolved : sequence of str
        Labels of runs that are not solved. Default: none.
    machine : MachineDrawing, optional
        The machine with its numbers on it. Default: none.
    has_drawing_within : bool
        Whether the first view has this drawing within it. Default: it stands above it.
    first, beside, parts : sequences of Part
        The first view; what stands between it and the charts; all others in their order.
    charted : ChartList
        The charts that its parts show.
    styles : sequence of str
        Style sheets beside those of all pages.
    script, engine : str
        Modules of scripts: the first runs on the page, the second one in a worker.
    shared : mapping
        Values for all parts, and values and functions for their macros.
    data : mapping
        Data for the scripts beside the charts.
    cited : sequence of str
        Works that it cites beside the program.
    source : str
        What it was made of, by which a command knows its own file. Default: it does not say it.
    """

    title: str
    noise: str = "contact noise"
    notice: str = ""
    unsolved: Sequence[str] = ()
    machine: MachineDrawing | None = None
    has_drawing_within: bool = False
    first: Sequence[Part]
    beside: Sequence[Part] = ()
    parts: Sequence[Part]
    charted: ChartList = field(default_factory=ChartList)
    styles: Sequence[str] = ()
    script: str = "page/plain.js"
    engine: str = ""
    shared: Mapping[str, Any] = field(default_factory=dict)
    data: Mapping[str, Any] = field(default_factory=dict)
    cited: Sequence[str] = ()
    source: str = ""

    def written(self) -> bytes:
        """Return the HTML file."""
        templates = environment()
        templates.globals |= {
            "chart_svg": chart_svg,
            "crowded": False,
            "numbered": self.charted.add,
            "sharing": self.charted.sharing,
            "text": text,
            "version": __version__,
            "machine": self.machine,
            **self.shared,
        }

        def shown(parts: Sequence[Part]) -> list[Markup]:
            """Write parts in the order of the page, which is that of its charts."""
            return [
                Markup(templates.get_template(part.template).render(part.values)) for part in parts
            ]

        templates.globals["shown"] = shown
        values = {
            "title": self.title,
            "source": self.source,
            "noise": self.noise,
            "notice": self.notice,
            "unsolved": self.unsolved,
            "has_drawing_within": self.has_drawing_within,
            "first": shown(self.first),
            "beside": shown(self.beside),
            "parts": shown(self.parts),
            "cited": self.cited,
            "css": Markup("".join(text.asset(name) for name in (*STYLES, *self.styles))),
            "js": Markup(joined_script(self.script)),
            "engine": Markup(joined_script(self.engine) if self.engine else ""),
            "data": {"labels": [], **self.data, "charts": [*map(_for_script, self.charted.shown)]},
        }
        return templates.get_template("page.html").render(values).encode()


def _for_script(chart: Chart) -> Chart:
    """Return a chart without the pixels of its image, which its drawing has."""
    parts = [
        {name: value for name, value in part.items() if name != "png"} for part in chart["parts"]
    ]
    return chart | {"parts": parts}
