"""Independent checks of the contact solver on scenes that are hard for it.

- `named_cases`, `random_cases`: scenes by name and by seed.
- `optimality`: the contact conditions of a state, checked by separate code.
- `dense`, `subcell_deflection`: second implementations of the solver and of its operator.
- `judge`: the outcome of a case.
"""
