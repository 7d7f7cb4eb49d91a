"""Scene: its sections, its quantities in SI, its file, and its messages.

section
    a strict model whose faults are words, in a file and in Python
sections, surfaces
    sphere, plate, rolling, numerics, recovery, dynamics and sound, and the kinds of surface, with
    units in the names of their keys
scene
    `Scene`: the sections together, the runs of its sweep, the track
sweep, run_names
    lists of values, their product and its faults; names of the runs
motion, track
    distance over time; the track in whole nodes and whole steps
file, yaml_text
    scenes as YAML, overrides, the JSON Schema; YAML as plain values with the line of each key
height_format, height_header, height_text
    formats of height files and their faults; nodes from the header; numbers in text
library
    scenes that come with the program, found by name
messages, identity
    faults in words; the physics that a result is solved for
"""
