"""Speed against error of a scene.

- `variants`: the same stretch of track with other grids, edges, tolerances and steps.
- `study`: marches of the variants, their errors as one `xarray.Dataset`, and the command.
- `work_precision`: table, advice and diagram of such a Dataset.
"""
