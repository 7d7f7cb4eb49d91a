"""Scene: its sections, its quantities in SI, its file, and its messages.

messages, models
    faults in words; the model of a section, the keys that it knows, its faults by key
library
    scenes, materials and finishes by name
track
    distance over time; the track in whole nodes and whole steps
sections, laws, surfaces, bodies
    strict models of rolling, numerics, recovery, dynamics and sound, the laws and single faults of
    heights, the kinds of surface, sphere and plate, with units in the names of their keys
height_files, height_grid
    heights from .npy, .npz, text and files of instruments; the nodes of their period
quantities, sweep, scene
    quantities in SI; lists of values and their product; `Scene`: the sections together, the rules
    that join them, and its runs
identity
    the keys that make a march, digests and differences of scenes
yaml_text, file
    plain values of a text with their lines; scenes as YAML, overrides, the JSON Schema
"""
