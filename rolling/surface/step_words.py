"""Names of forms and filters after ISO 25178-2 and ISO 16610."""

_FORMS = {
    "auto": "plane",
    "quadratic": "surface of second order",
}


def form_words(level: str) -> str:
    """Name the form that an F-operation removes, a value of the key `surface.level`.

    Examples
    --------
    >>> form_words("plane"), form_words("polynomial-4"), form_words("none")
    ('least-squares plane', 'least-squares polynomial of order 4', 'none')
    """
    if level == "none":
        return level
    name = _FORMS.get(level, level)
    return f"least-squares {name.replace('polynomial-', 'polynomial of order ')}"


def filter_words(index_m: float, is_robust: bool = False) -> str:
    """Name a filter with its nesting index [m].

    Examples
    --------
    >>> filter_words(8e-4), filter_words(8e-4, is_robust=True)
    ('Gaussian, nesting index 0.8 mm', 'robust Gaussian, nesting index 0.8 mm')
    """
    kind = "robust Gaussian" if is_robust else "Gaussian"
    return f"{kind}, nesting index {1e3 * index_m:g} mm"
