"""Design optimisation: hull and moorings searched for a site, stage by stage."""
