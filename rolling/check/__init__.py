"""Check of a scene before it is run: its cost, the credibility of its result, and refusals.

- `finding`: a row of the check
- `findings`: `check_scene` judges all runs of a scene, `check_run` a single run
- `resolution`, `height_findings`, `validity`, `vibration_limits`, `comb_spread`, `level_doubts`:
  rules by subject, namely spacing, steps and record; heights from a file and made; limits of the
  model, and of it with dynamics; a short lap; the level itself
- `force_estimate`: contact force from the statistics of the surface
- `probe` solves a few positions; `highest_summit`, `widest_places` and `narrow_surface` tell from
  heights alone where a contact will be wider than its surface
- `run_size`: the numbers of a run that its memory, its files and its steps are judged by
- `memory_and_disk`: bytes that runs take, from their sizes
- `cost`, `error_cost`, `forecast`: expected time and window
- `long_steps`, `refusals`: scenes that cannot be run here
- `marched`: check and refusals of the marches that a scene of any kind needs
- `in_short`: the check in few lines
"""
