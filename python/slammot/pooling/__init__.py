"""What many runs say together: of a study's cells, and of the runs of a comparison."""
