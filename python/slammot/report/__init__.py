"""The pages of comparisons and studies: tables, figures, verdicts in words."""
