"""How many tracks without a solution are foreseen: python tests/benchmarks/narrow_surface_study.py.

Each scene is marched on forty seeds. A track without a solution has a contact that is wider than
the surface somewhere. It is foreseen by positions that are solved (`reason_against`), and guessed
without a solve (`may_be_too_narrow`).
"""

from __future__ import annotations

import rolling as rc
from rolling.check.widest_places import may_be_too_narrow, reason_against
from rolling.contact.subcells import half_space_of
from rolling.in_si.contact_of_scene import rolling_contact

SEEDS = 40
BASE = {
    "name": "narrow",
    "sphere": {"material": "steel-100cr6", "radius_mm": 5},
    "plate": {"material": "steel-s235"},
    "surface": {
        "kind": "gaussian",
        "seed": 1,
        "roughness_ra_um": 0.1,
        "correlation_length_um": 12,
        "spacing_um": 4,
        "width_um": 128,
    },
    "rolling": {"load_n": 0.3, "speed_m_s": 0.1, "distance_mm": 0.4},
}
CHANGES: dict[str, dict[str, float]] = {
    "light": {},
    "narrower": {"surface.width_um": 96},
    "heavier": {"rolling.load_n": 2},
    "rough": {"surface.roughness_ra_um": 0.3, "surface.width_um": 192},
    "soft": {"surface.roughness_ra_um": 0.3, "surface.width_um": 192, "plate.hardness_gpa": 2},
}


def has_solution(scene: rc.Scene) -> bool:
    """March a track, and tell whether all its contacts have a solution."""
    contact = rolling_contact(scene)
    half_space = half_space_of(contact.spacing, contact.contact_modulus, contact.subcells)
    try:
        for _ in rc.march(contact, 0, scene.track.solved_steps, half_space):
            pass
    except rc.ContactError:
        return False
    return True


def main() -> None:
    """Print the table."""
    print("|scene|without a solution|foreseen|wrongly|guessed|wrongly|\n|---|---|---|---|---|---|")
    for name, changes in CHANGES.items():
        scene = rc.Scene.from_dict(BASE).with_(changes)
        failing = foreseen = wrongly = guessed = wrong_guesses = 0
        for seed in range(1, SEEDS + 1):
            track = scene.with_({"surface.seed": seed})
            fails = not has_solution(track)
            failing += fails
            is_foreseen = bool(reason_against(track))
            foreseen += is_foreseen and fails
            wrongly += is_foreseen and not fails
            is_guessed = may_be_too_narrow(track)
            guessed += is_guessed and fails
            wrong_guesses += is_guessed and not fails
        print(f"|{name}|{failing}|{foreseen}|{wrongly}|{guessed}|{wrong_guesses}|")


if __name__ == "__main__":
    main()
