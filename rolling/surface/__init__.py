"""Surface heights of a scene: generated or read, levelled, and described.

heights
    makes random, faulted and flat heights, and computes roughness statistics
made
    makes random heights of a law, with a skewness and a kurtosis from Johnson's system
measured
    reads and writes files of all formats, and makes a surface of an array of numpy
levelling
    checks heights, finds their tilt and seam, and removes the tilt
preparation
    fills, filters, resamples and closes measured heights by ISO 25178-3
parameters
    computes the areal parameters of ISO 25178-2
refined, contact_of_scene
    compute heights between the nodes, on other grids and on sub-cells, and the rolling contact
scene_surface
    gives the surface of a scene, plate and sphere together, with its statistics
"""
