"""Heights in files: read, written and described, and turned into the heights of a plate.

in_metres
    checks the numbers of a file, and returns metres
measured
    reads and writes files of all formats, and makes a surface of an array of numpy
plate_file
    reads and prepares the file of a plate by the keys of its section
offered_lines, described_file
    the section of a scene that is like a surface, or rolls over a file
"""
