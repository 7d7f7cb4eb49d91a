"""Kind of a scene whose runs are numbers, arrays and a sound: the base of further kinds."""
