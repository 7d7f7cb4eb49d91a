"""Independent checks of the contact solver: hard and random scenes, judged state by state.

- `hard_cases`, `random_cases`: scenes by name and by seed.
- `optimality`: the contact conditions of a state, checked by separate code.
- `judge`: outcomes and the report.
"""
