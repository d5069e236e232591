"""What laws do: swing-ups, climbs, regions of attraction, trials."""
