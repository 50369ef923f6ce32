"""Read OpenFAST decks and give the frequency-domain model of a floating wind turbine."""
