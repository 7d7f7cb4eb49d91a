"""Scene: its sections, its quantities in SI, its file, and its messages.

messages, models
    mistakes in words; the model of a section, the keys that it knows, its mistakes by key
library, bearing_names
    scenes, materials, finishes and bearings by name; names of bearings with their suffixes
track_length, length_choice
    the track of a scene, of the length that its keys ask for; the length that `auto` took
laws, surfaces, sections
    strict models: the laws and single faults of heights, the kinds of surface, and the sections
    sphere, plate, rolling, numerics, recovery, dynamics and sound, with units in names of keys
height_format, text_words, text_look, text_table, text_heights
    what all files of heights share; units and headings that instruments write; the look at a text;
    its table of numbers; the heights that it holds
height_files, hdf5_files, height_grid
    heights from .npy, .npz, text and files of instruments; the judge of HDF5 files; the nodes of
    their period
grid_error, automatic_tolerance, step_rule
    what the grid leaves in the release; tolerance of the solver and length of steps beside it
values_in_si, rules, transducers
    the sections together and their quantities in SI; the rules that join them; channels
sweep, swept, scene
    lists of values and their product; a scene of any kind, its changes and its runs; `Scene`
bearing_lengths, bearing_rules, bearing_sections, bearing_scene, bearing_sources
    the scene of a bearing: lengths in closed form, what does not fit, its sections, `BearingScene`,
    and where its values come from
raceways, roundness_files
    surface of a raceway: waves around and roughness with its lay; files of measured waves
identity, seeds, kept
    the keys that make a march, digests and differences of scenes; their random numbers; values that
    a process keeps
yaml_text, file
    plain values of a text with their lines; scenes of any kind as YAML, overrides, the JSON Schema
"""
