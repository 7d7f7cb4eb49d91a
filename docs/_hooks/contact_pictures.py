"""Pictures of contacts: pressure, roughness in a Hertz contact, and a plate that runs in."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from drawn_pictures import Drawn, legend_below, new_figure, plain

import rolling
from acoustics.numbers import rounded
from acoustics.plot_style import COLOURS, gridded
from rolling import closed_forms
from rolling.figures.contact_figures import YIELDED
from rolling.in_si import scene_surface

OUTSIDE = "#000004"  # of a map of pressure: the first colour of its scale
SHOWN_UM = 240.0  # of a plate that has run in, along and across the track


def pressure(scenes: Mapping[str, Any]) -> Drawn:
    """Draw the pressure of a contact, with its scale."""
    from picture_parts import kept_run

    run = kept_run(scenes["ball"])
    figure = new_figure(4.6)
    ax = plain(rolling.plot.contact_pressure(run, ax=figure.add_subplot()))
    ax.set_facecolor(OUTSIDE)
    contact = run.numbers.contact
    numbers = {
        "load": f"{run.scene.load:g} N",
        "hardness": f"{rounded(run.scene.hardness * 1e-9, 3)} GPa",
        "yielding": f"{rounded(100 * contact.plastic_ratio, 2)} %",
        "touching": f"{rounded(100 * contact.area_mean_m2 / contact.hertz_area_m2, 2)} %",
    }
    return Drawn(figure, numbers, frozenset({OUTSIDE, YIELDED.lower()}))


def roughness_in_hertz(scenes: Mapping[str, Any]) -> Drawn:
    """Draw the pressure through the middle of a smooth contact, and the peak of a rough one."""
    scene = scenes["ball"]
    modulus = scene.contact_modulus
    heights = scene_surface.heights(scene)
    nodes = min(heights.shape)
    x = scene.spacing * (np.arange(nodes) - nodes // 2)
    gap = (x[:, None] ** 2 + x**2) / (2 * scene.sphere.radius_mm * 1e-3)
    steel = rolling.HalfSpace(scene.spacing, modulus)
    smooth = rolling.solve_contact(steel, gap, scene.load)
    rough_gap = gap - heights[:nodes, :nodes]
    rough = rolling.solve_contact(steel, rough_gap - rough_gap.min(), scene.load)
    radius = closed_forms.hertz_radius(scene.load, scene.sphere.radius_mm * 1e-3, modulus)
    highest = closed_forms.hertz_pressure(scene.load, scene.sphere.radius_mm * 1e-3, modulus)
    figure = new_figure(3.4)
    ax = figure.add_subplot()
    middle = nodes // 2
    highest_row = int(np.argmax(rough.pressure.max(axis=1)))
    ax.plot(
        1e6 * x, 1e-9 * rough.pressure[highest_row], color=COLOURS[1], linewidth=1, label="rough"
    )
    inside = np.linspace(-radius, radius, 201)
    closed = highest * np.sqrt(np.maximum(0.0, 1 - (inside / radius) ** 2))
    ax.plot(1e6 * inside, 1e-9 * closed, color="0.35", linewidth=3, alpha=0.5, label="Hertz")
    every = slice(None, None, 3)
    ax.plot(
        1e6 * x[every],
        1e-9 * smooth.pressure[middle][every],
        "o",
        color=COLOURS[0],
        markersize=3,
        label="smooth, computed",
    )
    ax.set_xlim(-2e6 * radius, 2e6 * radius)
    gridded(ax, xlabel="across the contact [µm]", ylabel="pressure [GPa]")
    legend_below(figure, ax)
    error = abs(smooth.max_pressure / highest - 1)
    numbers = {
        "hertz pressure": f"{rounded(1e-9 * highest, 3)} GPa",
        "hertz radius": f"{rounded(1e6 * radius, 3)} µm",
        "error": f"{rounded(100 * error, 1)} %",
        "rough pressure": f"{rounded(1e-9 * rough.max_pressure, 2)} GPa",
        "touching": f"{rounded(100 * rough.contact_area / (np.pi * radius**2), 2)} %",
    }
    return Drawn(figure, numbers)


def running_in(scenes: Mapping[str, Any]) -> Drawn:
    """Draw a plate before its passes and after them, and the cut along the track through both."""
    from picture_parts import kept_run

    run = kept_run(scenes["plate"])
    spacing_um = 1e6 * run.scene.spacing
    before = 1e6 * scene_surface.heights(run.scene)
    after = 1e6 * run.result.heights_after_passes(before * 1e-6)
    count = round(SHOWN_UM / spacing_um)
    first = (run.result.solved_steps - count) // 2
    across = (before.shape[1] - count) // 2
    part = np.s_[first : first + count, across : across + count]
    figure = new_figure(4.8)
    places = figure.subplot_mosaic([["before", "after"], ["cut", "cut"]], height_ratios=[1.5, 1])
    limit = float(np.abs(before[part]).max())
    extent = (0.0, count * spacing_um, 0.0, count * spacing_um)
    for name, heights in (("before", before), ("after", after)):
        image = places[name].imshow(
            heights[part].T,
            cmap=matplotlib_map("cividis"),
            origin="lower",
            extent=extent,
            interpolation="none",
            vmin=-limit,
            vmax=limit,
        )
        places[name].set_title(name, fontsize="medium")
        places[name].set(xlabel="along [µm]", ylabel="across [µm]")
    figure.colorbar(image, ax=[places["before"], places["after"]], label="height [µm]")
    middle = before.shape[1] // 2
    x = spacing_um * np.arange(count)
    cut = places["cut"]
    cut.plot(x, before[first : first + count, middle], color=COLOURS[0], label="before")
    cut.plot(x, after[first : first + count, middle], color=COLOURS[1], label="after")
    gridded(cut, xlabel="along the track [µm]", ylabel="height [µm]")
    cut.set_xlim(0.0, x[-1])
    legend_below(figure, cut)
    passes = run.numbers.passes
    numbers = {
        "passes": f"{len(passes)}",
        "sunk": f"{rounded(float((before - after).max()), 2)} µm",
        "first work": f"{rounded(1e9 * passes[0].plastic_work_j, 2)} nJ",
        "last work": f"{rounded(1e9 * passes[-1].plastic_work_j, 2)} nJ",
    }
    return Drawn(figure, numbers)


def matplotlib_map(name: str) -> Any:
    """Return a map of so few colours that its image is small."""
    import matplotlib

    return matplotlib.colormaps[name].resampled(64)
