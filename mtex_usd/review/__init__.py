"""Looking at results: a self-contained page with a player and plots, and still pictures."""
