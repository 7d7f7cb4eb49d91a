"""Check of a scene before it is run: its cost, the credibility of its result, and refusals.

findings
    `check_scene` judges all runs of a scene, `findings` a single run
size, smooth_contact, sampling, height_files, validity
    findings by subject
long_steps, resonance
    limits behind the findings: step against contact, ball on its contact
vibration, force_estimate
    findings of a scene with dynamics, and its contact force from the statistics of the surface
probe
    solves a few positions
cost, demand, between_nodes, machine
    expected time and window; memory and disk; memory of sub-cells; memory and disk of this machine
refusals
    scenes that cannot be run here
finding, report
    a finding and its numbers in words; `Findings` of all runs of a scene and their table
"""
