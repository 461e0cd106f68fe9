"""Design: a measured year's power and the limits of a buoy, with exact derivatives by its dimensions and materials."""
