"""Contact of a sphere with a rough plate, elastic up to the hardness, and its march.

Public modules:

- `half_space`: pressure to deflection, Love's coefficients and the FFT convolution (`HalfSpace`).
- `subcells`: pressures on parts of cells, with transforms of whole cells (`SubcellSpace`).
- `solver`: one contact under a load (`solve_contact`, `WarmStart`, `SolverOptions`,
  `ContactError`).
- `window`, `state`: blocks of nodes (`Window`); the rolling contact and its state at a position
  (`RollingContact`, `ContactState`).
- `march`: the contact at successive positions (`march`), the choice of each window and the warm
  starts.
- `recovery`: the release from state to state, the energy ledger, recovery events (`step_energy`,
  `EventTable`).
- `closed_forms`: Hertz contact, and the release of a smooth sphere.

Private modules, mostly compiled:

- `_descent`, `_system`: one descent, and the named tuples that compiled passes take.
- `_compiled`: compilation by numba, with a cache wherever one can be kept.
- `_solver_kernels`: conjugate gradients: line search, residual, preconditioner (`precondition`),
  next direction; edges within cells (`cell_ranges`, `move_edges`).
- `_model`, `_model_kernels`, `_far_field_kernels`: the model problem that predicts who bears load
  next (`settle_model`), and its far field.
- `_candidate_kernels`, `_state_kernels`: search for the nodes that may be in contact; approach and
  violation of a state.
- `_transform_kernels`: passes around complex transforms of two rows of nodes at a time
  (`multiply`).
- `_loaded_kernels`: loaded nodes of a window, their reach and their measures.
- `_subcell_kernels`: passes between sub-cells and cells.
- `_projection`: pressures put within the bounds, with the load restored (`project`,
  `restore_load`, `settle_load`).
- `_march_kernels`: gap, overlap, extrapolation.
- `_recovery_kernels`: release of each node (`node_work`) and the events of the nodes.

The tests check all of this against the dense solver `rolling.verification.dense`.
"""
