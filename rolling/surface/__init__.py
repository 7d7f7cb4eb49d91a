"""Surface heights of a scene: generated or read, levelled, and described.

heights
    makes random and flat heights, and computes roughness statistics
made, johnson
    make random heights of a law, with a skewness and a kurtosis from Johnson's system
levelling
    reads heights from files, finds their tilt and seam, and removes the tilt
refined
    computes heights between the nodes, on finer and coarser grids and on sub-cells
scene_surface
    gives the surface of a scene, with its statistics and its digest
"""

from rolling.surface.heights import gaussian as gaussian
