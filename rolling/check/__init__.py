"""Check of a scene before it is run: its cost, the credibility of its result, and refusals.

- `findings`: `check_scene` judges all runs of a scene, `findings` a single run
- `resolution`, `heights`, `validity`: findings by subject, namely spacing, steps and record;
  heights from a file and made; limits of the model and of scenes with dynamics
- `probe` solves a few positions
- `cost`: expected time, window, memory and disk
- `refusals`: scenes that cannot be run here
- `finding`: a finding and its numbers in words
"""
