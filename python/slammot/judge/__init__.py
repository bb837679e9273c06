"""The judge's statistics: errors and NEES of one run, intervals over runs, and who is better in pairs of runs."""
