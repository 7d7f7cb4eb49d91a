"""Contact of a sphere with a rough plate, elastic up to the hardness, and its march.

Public modules:

- `closed_forms`: Hertz contact, and the release of a smooth sphere.
- `half_space`: pressure to deflection, Love's coefficients and the FFT convolution (`HalfSpace`);
  `subcells`: the same for pressures on parts of cells (`SubcellSpace`).
- `solver`: the contact of a window: judge, list candidates, descend, check (`converge`), with
  blended edges (`solve`), and its errors (`ContactError`).
- `single_contact`: one contact under a load, from a caller's numbers (`solve_contact`, `WarmStart`,
  `Contact`).
- `state`: windows (`Window`), the rolling contact and its state at a position (`RollingContact`,
  `ContactState`).
- `march`: the contact at successive positions, the choice of each window and the warm starts.
- `recovery`: release from state to state, energy ledger, recovery events (`step_energy`,
  `EventTable`).
- `compiling`, `compiling_ahead`: compilation by numba, with a cache wherever one can be kept, and
  ahead of the first march on spare cores; `cached_code`: the files of that cache.
- `scratch`: memory that a march keeps; `processor_time`: time that it takes, without compilation.
- `track`: the track and the speed along it (`Track`, `Travel`); `units`: heights that cannot be
  metres.
- `smooth_contact`, `estimated_contact`: the contact of smooth bodies (`SmoothContact`), and the
  estimated reach of a rough one.
- `memory`: the plate that remembers its indentation.
- `load_shares`: the linear response of a contact to its surface.

Private modules, mostly compiled. Functions marked `njit` are kernels, which are cached. Those
marked `inlined` are part of the kernels that call them. Those marked `linked` are compiled once and
called by name.

- `_descent_kernels`, `_system`: the one compiled loop, a descent by conjugate gradients
  (`descend`), and the named tuples of its passes.
- `_position_kernels`: passes over a window between descents: `judge`, `measure`, mixing of starts.
- `_linked`, `_kinds`: linked kernels, and the types that they take and return.
- `_by_address`, `_plans`: calls by address, of transforms and of the plans of FFTW.
- `_direct_kernels`: deflection of few candidates by direct sums, without transforms.
- `_solver_kernels`: conjugate gradients: line search, residual, preconditioner (`precondition`) and
  next direction.
- `_model_kernels`, `_far_field`: the model problem that predicts who bears load next
  (`settle_model`), and the half-space that it stands for.
- `_candidate_kernels`: nodes that may be in contact, and edges within their cells (`move_edges`).
- `_condition_kernels`: pressures within the bounds with the load restored (`project`,
  `restore_load`, `settle_load`), approach and violation.
- `_window_kernels`: gap, window of a position (`overlap`), extrapolation; loaded nodes of a
  solved state (`measures`), release of each node (`node_work`), events.
- `_transform_kernels`: passes around transforms of two rows of cells at a time (`multiply`), and
  between cells and sub-cells.
"""
