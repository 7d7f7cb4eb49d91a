"""The check of a scene before it is run: its cost, whether its result can be believed, and
refusals.

findings
    `check_scene` judges all runs of a scene, `findings` a single one
size, smooth_contact, sampling, height_files, validity
    findings by subject
long_steps, resonance, resolution
    limits behind the findings: step against contact, ball on its contact, error of the solver
probe
    solves a few positions
cost, demand, machine
    expected time and window; memory and disk; memory and disk of this machine
refusals
    scenes that cannot be run here
finding, report
    one finding and its numbers in words; `Findings`, all of a scene, and their table
"""
