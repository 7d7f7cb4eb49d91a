"""Studies behind commands of their own, which no run imports.

- `accuracy`: speed against error of a scene, as `rolling accuracy` does. `accuracy_variants`
  marches the same stretch with other grids, edges, tolerances and steps; `work_precision` makes
  table and diagram.
- `lee2025`: the study of Lee, Kim & Kim (2025), as `rolling reproduce` does; `lee2025_cases` runs
  the scenes, `lee2025_conditions` and `lee2025_statements.toml` judge, `lee2025_figures` draws.
- `validate`: the program beside published results, as `rolling validate` does; `bearing_truths`,
  `printed_truths` and `recording_truths` have the numbers of others that it computes again, and
  `slope_truths` the slopes that papers print.
- `output`: tables and pictures of studies in files.
"""
