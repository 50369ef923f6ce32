"""From parts to answers: assembly, solution, loads, statistics, identification."""
