"""What ISO 15242 asks of a measurement, and what a bearing in a scene does otherwise.

The text of ISO 15242-2 was not at hand. Its axial loads are those that are usually quoted for
single-row deep-groove ball bearings.
"""

from acoustics.numbers import rounded

SPEED_RPM = 1800.0
ANGULAR_DEG = 15.0  # least contact angle that makers give to angular contact bearings
SPEED_SHARE = 0.02  # of the speed that may be off
# Outside diameters up to a limit [mm], and the range of the axial load [N].
_AXIAL_LOADS_N = (
    (25.0, (18.0, 22.0)),
    (50.0, (63.0, 77.0)),
    (100.0, (135.0, 165.0)),
    (140.0, (360.0, 440.0)),
)
_LEAST_DIAMETER_MM = 10.0


def axial_load_range_n(outer_diameter_mm: float) -> tuple[float, float] | None:
    """Return the least and the largest axial load [N] for an outer diameter; None beyond sizes."""
    if outer_diameter_mm <= _LEAST_DIAMETER_MM:
        return None
    for most_mm, loads in _AXIAL_LOADS_N:
        if outer_diameter_mm <= most_mm:
            return loads
    return None


def departures(
    *,
    turning: str,
    speed_rpm: float,
    axial_load_n: float,
    radial_load_n: float,
    outer_diameter_mm: float,
) -> list[str]:
    """Return what a run does otherwise than ISO 15242 asks for, in words; empty for none."""
    texts = []
    if turning != "inner":
        texts.append("the outer ring turns and the inner one is measured")
    if abs(speed_rpm - SPEED_RPM) > SPEED_SHARE * SPEED_RPM:
        texts.append(f"{rounded(speed_rpm, 4)} rpm instead of 1800")
    allowed = axial_load_range_n(outer_diameter_mm)
    if allowed is None:
        texts.append(f"no load is quoted for an outer diameter of {outer_diameter_mm:g} mm")
    elif not allowed[0] <= axial_load_n <= allowed[1]:
        text = f"{rounded(axial_load_n, 3)} N axial instead of {allowed[0]:g} to {allowed[1]:g} N"
        texts.append(text)
    if radial_load_n > 0:
        texts.append(f"{rounded(radial_load_n, 3)} N radial instead of none")
    return texts
