"""Scene: its sections, its quantities in SI, its file, and its messages.

sections, bodies, surfaces, laws
    strict models of sphere, plate, rolling, numerics, recovery, dynamics and sound, the kinds of
    surface, and their laws and faults, with units in the names of their keys
scene, quantities
    `Scene`: the sections together, the rules that join them, its runs, its quantities in SI
sweep
    lists of values, their product and its faults; names, identities and differences of runs
track
    distance over time; the track in whole nodes and whole steps
file, library
    scenes as YAML, overrides, the JSON Schema; scenes, materials and finishes by name
height_files, height_grid
    heights from .npy, .npz, text and files of instruments; the nodes of their period
messages
    faults in words
"""
