"""Writers: results, figures, reports and the formats that other programs read."""
