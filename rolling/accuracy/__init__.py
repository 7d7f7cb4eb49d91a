"""Speed against error of a scene: its variants, their errors, and the text and plot of a study.

- `study`: the command.
- `variants`: grids, steps and solver settings to compare.
- `kept`: pieces on disk, so that a study that was stopped goes on.
- `record`: levels of parts of the track, for the length of the record.
- `errors`: numbers of a variant, errors, orders, recommendation.
- `text`, `plot`: accuracy.md and its picture.
"""
