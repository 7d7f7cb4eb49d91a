"""Scene: its sections, its quantities in SI, its file, and its messages.

sections, surfaces
    strict models of sphere, plate, rolling, numerics, recovery, dynamics and sound, and the kinds
    of surface, with units in the names of their keys
scene
    `Scene`: the sections together, the runs of its sweep, the track, the rule of the tolerance
sweep
    lists of values, their product and its faults; names of the runs
motion, track
    distance over time; the track in whole nodes and whole steps
file, yaml_text, library
    scenes as YAML, overrides, the JSON Schema; YAML as plain values with the line of each key;
    scenes that come with the program
height_files, instruments, height_grid
    heights from .npy, .npz and text, and from files of instruments; the nodes of their period
messages, identity
    faults in words; digests of scenes, keys that the march depends on, differences in words
"""
