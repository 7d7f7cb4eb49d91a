"""The report page of a sweep with many runs: their common settings, and their levels."""

from __future__ import annotations

from collections.abc import Sequence

from rolling.report import citation, hearing
from rolling.report import text as report_text
from rolling.report.page import GENERATOR, Exhibit
from rolling.report.templates import environment, own_text
from rolling.simulation.run_result import RunResult


def page(
    runs: Sequence[RunResult], exhibits: Sequence[Exhibit], unheard: Sequence[str] = ()
) -> bytes:
    """Write the page of many runs, without players and without pictures of a single run.

    Parameters
    ----------
    runs : sequence of runs, at least one, in the order of the page. Their labels differ.
    exhibits : sequence of Exhibit. Pictures of all runs together.
    unheard : sequence of str. Labels of runs that have too few steps for a sound. Default: none.

    Returns
    -------
    bytes
        The HTML file.
    """
    html = (
        environment()
        .get_template("sweep.html")
        .render(
            generator=GENERATOR,
            title=report_text.titles(runs),
            descriptions=[],
            text=report_text,
            hearing=hearing,
            citation=citation,
            runs=runs,
            unheard=list(unheard),
            curves=exhibits,
            css=own_text("report.css"),
        )
    )
    return html.encode()
