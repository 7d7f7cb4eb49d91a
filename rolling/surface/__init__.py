"""Surface heights of a scene: generated or read, levelled, and described.

heights
    makes random and flat heights, and computes roughness statistics
made, johnson
    make random heights of a law, with a skewness and a kurtosis from Johnson's system
height_array
    makes a surface of an array of numpy
levelling
    checks heights, finds their tilt and seam, and removes the tilt
measured
    reads and writes files of all formats
parameters
    computes the areal parameters of ISO 25178-2
preparation
    fills, filters, resamples and closes measured heights by ISO 25178-3
refined
    computes heights between the nodes, on finer and coarser grids and on sub-cells
scene_surface
    gives the surface of a scene, with its statistics and its digest
"""

from rolling.surface.heights import gaussian as gaussian
