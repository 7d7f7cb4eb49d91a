"""Choice between scenes: which one is quieter, by how much, how sure is that, what would help."""
